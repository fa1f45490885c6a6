//! Channels for other programs: written by rules, and passed over by this reader.

use crate::common::end;
use bksim_log::{
    Area, Entity, Field, Header, Joint, JointState, Level, Line, Log, LogError, LogWriter, Moment,
    Placement, Record, Stage, Topic,
};

/// A frame with a triangle and a line, one joint, and something that stretches.
fn stage() -> Stage {
    let color = [0.25, 0.5, 0.75, 1.0];
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let area = Area { points: points.clone(), triangles: vec![[0, 1, 2]], color };
    let line = Line { points, is_closed: true, width: 2.0, color };
    let (id, frame) = ("crank/0".to_owned(), "crank".to_owned());
    Stage {
        root: "ground".into(),
        frames: vec!["crank".into()],
        entities: vec![Entity { id, frame, areas: vec![area], lines: vec![line] }],
        rods: Vec::new(),
        has_spans: true,
        joints: vec![Joint { name: "A_angle".into(), unit: "rad".into() }],
    }
}

fn moment() -> Moment {
    let spans = vec![Entity { id: "K".into(), frame: "ground".into(), ..Entity::default() }];
    Moment { frames: vec![Placement::default()], joints: vec![JointState::default()], spans }
}

fn header() -> (Header, bksim_log::TopicId) {
    let mut header = Header::new("m", "toml", "", "");
    (header.t_start, header.t_end) = (3.0, -1.0);
    let state = header.add_topic(Topic::new("/state", [Field::new("A_angle", "rad", "")]));
    (header, state)
}

#[test]
fn a_log_with_viewers_reads_as_one_without() -> Result<(), LogError> {
    let (header, state) = header();
    let log = |has_viewers: bool| {
        let mut writer = LogWriter::create(Vec::new(), &header)?;
        let mut viewers = has_viewers.then(|| writer.add_viewers(&stage())).transpose()?;
        for t in [3.0, 2.5, -1.0] {
            writer.write(state, t, &[t])?;
            if let Some(viewers) = &mut viewers {
                writer.show(viewers, t, &moment())?;
            }
        }
        writer.note(Level::Info, 0.5, "back in time")?;
        writer.finish(&end())
    };
    let (with, without) = (log(true)?, log(false)?);
    assert!(with.len() > without.len() + 1000);
    let read = Log::read(&with[..])?;
    assert_eq!(read, Log::read(&without[..])?);
    assert_eq!(read.notes[0].t, 0.5);
    Ok(())
}

#[test]
fn what_is_shown_is_complete_and_in_order() -> Result<(), LogError> {
    let (header, state) = header();
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    let mut viewers = writer.add_viewers(&stage())?;
    writer.show(&mut viewers, 2.0, &moment())?;
    // A run back in time does not go forward.
    let refused = writer.show(&mut viewers, 2.5, &moment());
    assert!(matches!(refused, Err(LogError::BadTime { previous: 2.0, .. })), "{refused:?}");
    let short = Moment { frames: Vec::new(), ..moment() };
    let refused = writer.show(&mut viewers, 1.0, &short).expect_err("one frame").to_string();
    assert_eq!(refused, "topic `/tf` has 1 fields, the sample 0 values");
    let short = Moment { joints: Vec::new(), ..moment() };
    let refused = writer.show(&mut viewers, 1.0, &short).expect_err("one joint").to_string();
    assert_eq!(refused, "topic `/joint_states` has 1 fields, the sample 0 values");
    // Nothing of that was written, and the log goes on.
    writer.write(state, 1.5, &[0.0])?;
    let bytes = writer.finish(&end())?;
    let mut reader = bksim_log::LogReader::open(&bytes[..])?;
    let first = reader.next_record()?;
    assert!(matches!(first, Some(Record::Sample { t: 1.5, .. })), "{first:?}");
    Ok(())
}

#[test]
fn a_scene_of_any_size_is_told_in_messages_that_can_be_read() -> Result<(), LogError> {
    let (header, _) = header();
    let shape = |n_points: usize| {
        let points = (0..n_points).map(|i| [i as f64, 1.0, 1.0]).collect();
        let line = Line { points, is_closed: false, width: 1.0, color: [1.0; 4] };
        Entity { id: "s".into(), frame: "crank".into(), lines: vec![line], areas: Vec::new() }
    };
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    // Four megabytes in sixteen shapes.
    let entities = (0..16).map(|_| shape(10_000)).collect();
    writer.add_viewers(&Stage { entities, ..stage() })?;
    let largest = largest_message(&writer.finish(&end())?);
    assert!((700_000..1_100_000).contains(&largest), "{largest} bytes");
    // One shape that no reader would take is refused before anything is written.
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    let entities = vec![shape(1 << 20)];
    let refused = writer.add_viewers(&Stage { entities, ..stage() });
    assert!(matches!(refused, Err(LogError::TooLarge { what: "a shape", .. })), "{refused:?}");
    writer.add_viewers(&stage())?;
    writer.finish(&end()).map(drop)
}

/// Bytes of the largest message of a log.
fn largest_message(log: &[u8]) -> usize {
    let messages = mcap::MessageStream::new(log).expect("an MCAP file");
    messages.map(|message| message.expect("a message").data.len()).max().unwrap_or_default()
}

#[test]
fn no_topic_of_samples_takes_the_name_of_theirs() {
    for name in ["/tf", "/scene", "/spans", "/joint_states", "/outlines/crank"] {
        let mut header = Header::new("m", "toml", "", "");
        header.add_topic(Topic::new(name, [Field::new("x", "", "")]));
        let refused = LogWriter::create(Vec::new(), &header).map(drop).expect_err("taken");
        assert_eq!(refused.to_string(), format!("topic `{name}` is there twice"));
    }
}
