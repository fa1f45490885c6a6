// The words of the page in Vietnamese; English is what the page is written in.

const VI: Record<string, string> = {
  Undo: 'Hoàn tác',
  Redo: 'Làm lại',
  'Undo (Ctrl+Z)': 'Hoàn tác (Ctrl+Z)',
  'Redo (Ctrl+Y)': 'Làm lại (Ctrl+Y)',
  Share: 'Chia sẻ',
  'A link that holds this model': 'Liên kết chứa mô hình này',
  Export: 'Xuất',
  'Files of what is shown': 'Tệp của những gì đang hiển thị',
  'Picture (PNG)': 'Ảnh (PNG)',
  'Picture (SVG)': 'Ảnh (SVG)',
  'Curves (CSV)': 'Đường cong (CSV)',
  'Model (TOML)': 'Mô hình (TOML)',
  Save: 'Lưu',
  Download: 'Tải về',
  'The text as a TOML file (Ctrl+S)': 'Văn bản dưới dạng tệp TOML (Ctrl+S)',
  'Dark theme': 'Nền tối',
  'Light or dark': 'Sáng hoặc tối',
  'The mechanism': 'Cơ cấu',
  Tools: 'Công cụ',
  Hand: 'Tay',
  'Drag a point or body': 'Kéo một điểm hoặc một vật',
  'Drag any point or body; click a point to see its path.': 'Kéo một điểm hoặc một vật bất kỳ; nhấp một điểm để xem quỹ đạo của nó.',
  Shape: 'Hình dạng',
  'Drag points to change lengths': 'Kéo điểm để thay đổi chiều dài',
  'Drag a point to change lengths.': 'Kéo một điểm để thay đổi chiều dài.',
  'Drag a point with a name; bodies keep their shape.': 'Hãy kéo một điểm có tên; vật giữ nguyên hình dạng.',
  Select: 'Chọn',
  'Hold several bodies at once': 'Giữ nhiều vật cùng lúc',
  'Click bodies or draw around them; drag, Ctrl+D or Delete moves, copies or deletes them.':
    'Nhấp các vật hoặc khoanh quanh chúng; kéo, Ctrl+D hay Delete để dời, sao chép hay xóa.',
  Link: 'Khâu',
  'Draw a link': 'Vẽ một khâu',
  'Click both ends of a link; an end on a point gets a pin.': 'Nhấp hai đầu của khâu; đầu nằm trên một điểm sẽ có khớp bản lề.',
  Plate: 'Tấm',
  'Draw a plate with three corners or more': 'Vẽ một tấm có từ ba góc trở lên',
  'Click the corners of a plate; click the first one again to end it.': 'Nhấp các góc của tấm; nhấp lại góc đầu tiên để kết thúc.',
  'A plate has three corners or more, not in one line.': 'Một tấm có từ ba góc trở lên, không thẳng hàng.',
  Ground: 'Giá',
  'Pin a point to the ground': 'Nối bản lề một điểm với giá',
  'Click a point to pin it to the ground.': 'Nhấp một điểm để nối bản lề với giá.',
  Pin: 'Bản lề',
  'Join two points': 'Nối hai điểm',
  'Click two points to join them with a pin.': 'Nhấp hai điểm để nối chúng bằng khớp bản lề.',
  Slide: 'Trượt',
  'Let a point slide along a line': 'Cho một điểm trượt theo một đường thẳng',
  'Click a point, then a place in the direction in which it slides.': 'Nhấp một điểm, rồi nhấp một chỗ theo hướng trượt của nó.',
  Slot: 'Rãnh',
  'Let a point of a body slide along another body': 'Cho một điểm của vật trượt dọc theo vật khác',
  'Click the body with the slot, then the point that slides along it.': 'Nhấp vật có rãnh, rồi nhấp điểm trượt dọc theo rãnh.',
  Gears: 'Bánh răng',
  'Let two wheels mesh': 'Cho hai bánh ăn khớp',
  'Click the joints of two wheels that mesh.': 'Nhấp khớp của hai bánh ăn khớp với nhau.',
  Spring: 'Lò xo',
  'A spring between two points': 'Lò xo giữa hai điểm',
  'Click both ends of a spring.': 'Nhấp hai đầu của lò xo.',
  Damper: 'Giảm chấn',
  'A damper between two points': 'Bộ giảm chấn giữa hai điểm',
  'Click both ends of a damper.': 'Nhấp hai đầu của bộ giảm chấn.',
  Force: 'Lực',
  'A force on a point': 'Lực đặt tại một điểm',
  'Click a point, then the tip of the force.': 'Nhấp một điểm, rồi nhấp mút của lực.',
  Motor: 'Động cơ',
  'Drive a joint': 'Dẫn động một khớp',
  'This joint is driven already.': 'Khớp này đã được dẫn động.',
  'Click a joint to drive it.': 'Nhấp một khớp để dẫn động.',
  Gravity: 'Trọng lực',
  'Gravity along −y': 'Trọng lực theo −y',
  Copy: 'Sao chép',
  'Copy a body': 'Sao chép một vật',
  'Click a body, then the place of its copy.': 'Nhấp một vật, rồi nhấp chỗ đặt bản sao.',
  Mirror: 'Đối xứng',
  'Copy a body, mirrored': 'Sao chép một vật qua phép đối xứng',
  'Click a body, then the place of its mirror image.': 'Nhấp một vật, rồi nhấp chỗ đặt ảnh đối xứng.',
  Delete: 'Xóa',
  'Delete a body': 'Xóa một vật',
  'Click a body to delete it with all that hangs on it.': 'Nhấp một vật để xóa cùng mọi thứ gắn vào nó.',
  Picture: 'Ảnh nền',
  'A picture underneath, to draw over': 'Ảnh nằm dưới để vẽ theo',
  'Picture underneath': 'Ảnh nằm dưới',
  'Click two places of the picture whose distance is known.': 'Nhấp hai chỗ trên ảnh có khoảng cách đã biết.',
  'How far are these two places apart?': 'Hai chỗ này cách nhau bao xa?',
  'This file is no picture.': 'Tệp này không phải là ảnh.',
  'The mechanism: N goes to the next point, arrow keys move, Enter takes hold and lets go':
    'Cơ cấu: N đi đến điểm kế tiếp, các phím mũi tên di chuyển, Enter nắm và thả',
  View: 'Khung nhìn',
  'Zoom in': 'Phóng to',
  'Zoom out': 'Thu nhỏ',
  'Show all': 'Xem tất cả',
  Motion: 'Chuyển động',
  'One frame back': 'Lùi một khung hình',
  Play: 'Chạy',
  'Play or pause (space)': 'Chạy hoặc dừng (phím cách)',
  'One frame on': 'Tiến một khung hình',
  Loop: 'Lặp',
  Speed: 'Tốc độ',
  Live: 'Trực tiếp',
  'Let it move, and pull at it': 'Cho cơ cấu chuyển động và kéo nó',
  'It moves: pull at it, slide a length; press Live again to stop.': 'Cơ cấu đang chuyển động: hãy kéo nó, đổi chiều dài; nhấn Trực tiếp lần nữa để dừng.',
  'Recorded: play it, or change something to have the model’s own motion again.': 'Đã ghi: hãy phát lại, hoặc thay đổi gì đó để có lại chuyển động của mô hình.',
  'To start': 'Về đầu',
  'Go back to the pose of the start': 'Trở về vị trí đầu',
  'Start here': 'Bắt đầu tại đây',
  'Write this pose into the model as its start': 'Ghi vị trí này vào mô hình làm vị trí đầu',
  Names: 'Tên',
  Dimensions: 'Kích thước',
  'Distances of points, to be typed in place': 'Khoảng cách giữa các điểm, gõ trực tiếp tại chỗ',
  Before: 'Trước đó',
  'The motion before the last change, faintly': 'Chuyển động trước lần thay đổi cuối, hiện mờ',
  Time: 'Thời gian',
  Faults: 'Lỗi',
  'The model': 'Mô hình',
  Values: 'Giá trị',
  Elements: 'Phần tử',
  Text: 'Văn bản',
  Curves: 'Đường cong',
  Equations: 'Phương trình',
  Ways: 'Cách lắp',
  Study: 'Khảo sát',
  Limits: 'Giới hạn',
  'Numbers at this pose': 'Số tại vị trí này',
  'transmission angle': 'góc truyền động',
  'Four-bars': 'Cơ cấu bốn khâu',
  'Slider-cranks': 'Cơ cấu tay quay con trượt',
  Ranges: 'Khoảng chuyển động',
  'Limit positions': 'Vị trí giới hạn',
  'Transmission angles': 'Góc truyền động',
  joints: 'khớp',
  lengths: 'chiều dài',
  links: 'khâu',
  offset: 'độ lệch tâm',
  'Barker’s type': 'kiểu theo Barker',
  smallest: 'nhỏ nhất',
  largest: 'lớn nhất',
  value: 'giá trị',
  where: 'tại',
  least: 'nhỏ nhất',
  greatest: 'lớn nhất',
  'Not kept to': 'Không xét đến',
  Arrows: 'Mũi tên',
  Velocities: 'Vận tốc',
  Reactions: 'Phản lực',
  'Free body': 'Vật tách rời',
  'all bodies': 'mọi vật',
  Paths: 'Quỹ đạo',
  From: 'Từ',
  Moment: 'Mômen',
  joint: 'khớp',
  contact: 'tiếp xúc',
  load: 'tải',
  belt: 'đai',
  rope: 'dây',
  drive: 'dẫn động',
  coupling: 'liên kết truyền động',
  'The text of the model': 'Văn bản của mô hình',
  'another key': 'khóa khác',
  Parameters: 'Tham số',
  Drives: 'Dẫn động',
  Start: 'Trạng thái đầu',
  Licences: 'Giấy phép',
  'No values yet: draw a link.': 'Chưa có giá trị: hãy vẽ một khâu.',
  'Nothing yet: choose the tool Link and click twice.': 'Chưa có gì: chọn công cụ Khâu và nhấp hai lần.',
  'Saved.': 'Đã lưu.',
  'The file was changed by another program, and is read again.': 'Tệp đã bị chương trình khác thay đổi và được đọc lại.',
  'The file was changed by another program; undo the changes here to take it.': 'Tệp đã bị chương trình khác thay đổi; hãy hoàn tác ở đây để nhận nó.',
  '`bksim edit` has ended: download the text to keep it.': '`bksim edit` đã kết thúc: hãy tải văn bản về để giữ.',
  'The link to this model is in the clipboard.': 'Liên kết đến mô hình này đã ở trong bộ nhớ tạm.',
  'The address of this page now holds the model.': 'Địa chỉ của trang này nay chứa mô hình.',
  'Mechanisms in space are held and seen, not drawn.': 'Cơ cấu không gian chỉ được nắm và xem, không vẽ được.',
  'dead point': 'điểm chết',
  guess: 'ước đoán',
  'Guesses of the start': 'Ước đoán trạng thái đầu',
  line: 'dòng',
  help: 'cách sửa',
  '1 free motion': '1 bậc tự do',
  '# free motions': '# bậc tự do',
  'one driven': '1 được dẫn động',
  '# driven': '# được dẫn động',
  '; Grübler’s formula counts #': '; công thức Grübler đếm được #',
  '; # redundant condition': '; # ràng buộc thừa',
  '; # redundant conditions': '; # ràng buộc thừa',
};

let table: Record<string, string> = {};

/** A text of the page in its language. */
export function word(text: string): string {
  return table[text] ?? text;
}

let codes: Record<string, [title: string, meaning: string, cure: string]> = {};

/** Takes titles, meanings and cures of faults in the language of the page. */
export function takeCodes(known: typeof codes): void {
  codes = known;
}

/** Title, meaning and cure of a code in the language of the page; none in English. */
export function codeWords(code: string): (typeof codes)[string] | undefined {
  return codes[code];
}

/** A fault in one line. */
export function faultWords({ code, message, help }: { code: string; message: string; help: string | null }): string {
  const known = codeWords(code);
  const cure = known?.[2] ?? help;
  return `${code}: ${known ? `${known[0]} (${message})` : message}${cure ? `; ${cure}` : ''}`;
}

/** Puts the page into a language, if that is not English; all others than Vietnamese are. */
export function translate(language: string): boolean {
  if (!language.toLowerCase().startsWith('vi')) return false;
  table = VI;
  document.documentElement.lang = 'vi';
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const text = node.nodeValue?.trim() ?? '';
    const isShown = text !== '' && !node.parentElement?.closest('script, pre');
    if (isShown && table[text]) node.nodeValue = (node.nodeValue ?? '').replace(text, table[text]);
  }
  for (const name of ['title', 'aria-label']) {
    for (const part of document.querySelectorAll(`[${name}]`)) part.setAttribute(name, word(part.getAttribute(name) ?? ''));
  }
  return true;
}
