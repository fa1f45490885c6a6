//! Films are decoded again, and show the right frames at the right times.

use bksim_view::film::{Colors, Film, FilmFormat, Palette, write_png};
use bksim_view::offscreen::Image;

const SIZE: [u32; 2] = [64, 48];
const N_FRAMES: usize = 7;
const BACKGROUND: [u8; 4] = [255, 255, 255, 255];
const BLOCK: [u8; 4] = [47, 111, 181, 255];

/// A block that moves to the right.
fn frame(k: usize, background: [u8; 4]) -> Image {
    let [width, height] = SIZE.map(|n| n as usize);
    let is_block = |at: usize| {
        let (x, y) = (at % width, at / width);
        (8 + 4 * k..24 + 4 * k).contains(&x) && (16..32).contains(&y)
    };
    let pixel = |at: usize| if is_block(at) { BLOCK } else { background };
    let rgba: Vec<[u8; 4]> = (0..width * height).map(pixel).collect();
    Image { size: SIZE, rgba: rgba.into_flattened() }
}

fn film(format: FilmFormat, fps: f64, background: [u8; 4]) -> Vec<u8> {
    let mut colors = Colors::default();
    colors.add(&frame(0, background));
    let palette = Palette::of(colors);
    let mut bytes = Vec::new();
    let mut film = Film::begin(&mut bytes, format, SIZE, fps, N_FRAMES, palette).expect("a film");
    for k in 0..N_FRAMES {
        film.add(&frame(k, background)).expect("a frame");
    }
    film.finish().expect("the end");
    bytes
}

#[test]
fn an_apng_loses_nothing() {
    let bytes = film(FilmFormat::Apng, 30.0, BACKGROUND);
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    let control = *reader.info().animation_control().expect("it is animated");
    assert_eq!((control.num_frames as usize, control.num_plays), (N_FRAMES, 0));
    for k in 0..N_FRAMES {
        let mut rgba = vec![0; reader.output_buffer_size().expect("a small picture")];
        reader.next_frame(&mut rgba).expect("a frame");
        let shown = reader.info().frame_control().expect("its delay");
        assert_eq!((shown.delay_num, shown.delay_den), (1, 30));
        assert!(rgba == frame(k, BACKGROUND).rgba, "frame {k} differs");
    }
}

#[test]
fn a_png_is_one_picture() {
    let image = frame(3, [0; 4]);
    let mut bytes = Vec::new();
    write_png(&mut bytes, &image).expect("a picture");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    assert!(reader.info().animation_control().is_none());
    let mut rgba = vec![0; reader.output_buffer_size().expect("a small picture")];
    reader.next_frame(&mut rgba).expect("a frame");
    assert_eq!(rgba, image.rgba);
}

/// The frames of a GIF as a viewer composes them, and their delays in hundredths of a second.
fn gif_frames(bytes: &[u8]) -> (Vec<Vec<[u8; 4]>>, Vec<u16>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(bytes).expect("a GIF");
    let width = usize::from(reader.width());
    assert_eq!([width, usize::from(reader.height())], SIZE.map(|n| n as usize));
    assert_eq!(reader.repeat(), gif::Repeat::Infinite);
    let mut shown = vec![[0; 4]; width * usize::from(reader.height())];
    let (mut frames, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = reader.read_next_frame().expect("a frame") {
        for (at, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
            let (x, y) = (at % usize::from(frame.width), at / usize::from(frame.width));
            if pixel[3] > 0 {
                shown[(usize::from(frame.top) + y) * width + usize::from(frame.left) + x] = *pixel;
            }
        }
        frames.push(shown.clone());
        delays.push(frame.delay);
        if frame.dispose == gif::DisposalMethod::Background {
            shown.fill([0; 4]);
        }
    }
    (frames, delays)
}

#[test]
fn a_gif_shows_every_frame_for_the_right_time() {
    for background in [BACKGROUND, [0; 4]] {
        let (frames, delays) = gif_frames(&film(FilmFormat::Gif, 30.0, background));
        assert_eq!(frames.len(), N_FRAMES);
        for (k, shown) in frames.iter().enumerate() {
            assert!(shown.as_flattened() == frame(k, background).rgba, "frame {k} differs");
        }
        // 30 a second are 3⅓ hundredths each: 7 frames last 23.
        assert_eq!(delays, [3, 4, 3, 3, 4, 3, 3]);
    }
}

#[test]
fn a_gif_stores_only_what_changes() {
    let bytes = film(FilmFormat::Gif, 25.0, BACKGROUND);
    let mut reader = gif::DecodeOptions::new().read_info(&bytes[..]).expect("a GIF");
    let mut sizes = Vec::new();
    while let Some(frame) = reader.next_frame_info().expect("a frame") {
        sizes.push([frame.left, frame.top, frame.width, frame.height]);
    }
    assert_eq!(sizes[0], [0, 0, 64, 48]);
    assert_eq!(sizes[1], [8, 16, 20, 16]);
}

#[cfg(feature = "mp4")]
mod mp4 {
    use super::*;

    /// The content of the box at the end of a path such as `moov/trak/mdia`.
    fn content<'a>(mut bytes: &'a [u8], path: &str) -> &'a [u8] {
        'parts: for part in path.split('/') {
            while bytes.len() >= 8 {
                let length = u32::from_be_bytes(bytes[..4].try_into().expect("four")) as usize;
                if &bytes[4..8] == part.as_bytes() {
                    bytes = &bytes[8..length];
                    continue 'parts;
                }
                bytes = &bytes[length..];
            }
            panic!("there is no `{part}` of `{path}`");
        }
        bytes
    }

    fn number(bytes: &[u8], at: usize) -> u32 {
        u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    }

    const TABLE: &str = "moov/trak/mdia/minf/stbl";

    #[test]
    fn an_mp4_counts_and_times_its_frames() {
        let bytes = film(FilmFormat::Mp4, 30.0, BACKGROUND);
        assert_eq!(&bytes[4..8], b"ftyp");
        let sizes = content(&bytes, &format!("{TABLE}/stsz"));
        assert_eq!(number(sizes, 8) as usize, N_FRAMES);
        let header = content(&bytes, "moov/trak/mdia/mdhd");
        let (per_second, duration) = (number(header, 12), number(header, 16));
        let seconds = f64::from(duration) / f64::from(per_second);
        assert!((seconds - N_FRAMES as f64 / 30.0).abs() < 1e-3, "{seconds} s");
        // One run of equal durations.
        let times = content(&bytes, &format!("{TABLE}/stts"));
        assert_eq!([number(times, 4) as usize, number(times, 8) as usize], [1, N_FRAMES]);
        assert_eq!(number(times, 12) * 30, per_second);
        let track = content(&bytes, "moov/trak/tkhd");
        let side = |from_end: usize| number(track, track.len() - from_end) >> 16;
        assert_eq!([side(8), side(4)], SIZE);
    }

    #[test]
    fn an_mp4_shows_the_frames_that_were_added() {
        let bytes = film(FilmFormat::Mp4, 30.0, BACKGROUND);
        let sizes = content(&bytes, &format!("{TABLE}/stsz"));
        let sizes: Vec<usize> = (0..N_FRAMES).map(|k| number(sizes, 12 + 4 * k) as usize).collect();
        let mut data = content(&bytes, "mdat");

        // The parameter sets are outside of the samples, whose parts have their lengths before
        // them.
        let description = content(&content(&bytes, &format!("{TABLE}/stsd"))[8..], "avc1");
        let sets = content(&description[78..], "avcC");
        let first = usize::from(u16::from_be_bytes([sets[6], sets[7]]));
        let second = 8 + first + 3;
        let mut stream =
            [&[0, 0, 0, 1], &sets[8..8 + first], &[0, 0, 0, 1], &sets[second..]].concat();
        let mut decoder = openh264::decoder::Decoder::new().expect("a decoder");
        for (k, size) in sizes.into_iter().enumerate() {
            let (mut sample, rest) = data.split_at(size);
            data = rest;
            while !sample.is_empty() {
                let end = 4 + number(sample, 0) as usize;
                stream.extend([0, 0, 0, 1]);
                stream.extend(&sample[4..end]);
                sample = &sample[end..];
            }
            let decoded = decoder.decode(&stream).expect("a frame").expect("a picture");
            let mut rgba = vec![0; frame(0, BACKGROUND).rgba.len()];
            decoded.write_rgba8(&mut rgba);
            stream.clear();
            let expected = frame(k, BACKGROUND).rgba;
            let off = rgba.iter().zip(&expected).filter(|(a, b)| a.abs_diff(**b) > 24).count();
            assert!(off * 100 < rgba.len(), "frame {k}: {off} of {} bytes differ", rgba.len());
        }
    }
}
