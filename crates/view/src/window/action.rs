//! [`Action`]: the actions of keys and buttons; and the table of keys, which the help is made from,
//! too.

use bksim_scene::StandardView;
use egui::{Key, Modifiers};

/// An action of a key or a button.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Action {
    /// Plays, or pauses.
    Play,
    /// Moves by a number of frames.
    Frame(i32),
    /// Moves to an end of a step of the integrator.
    LogStep {
        /// To the next end rather than the previous one.
        is_onward: bool,
    },
    /// Moves to the first instant.
    Start,
    /// Moves to the last instant.
    End,
    /// Moves by a number of steps through the list of speeds.
    Speed(isize),
    /// Returns to the speed of the motion itself.
    RealSpeed,
    /// Plays in a loop, or stops at the end.
    Loop,
    /// Begins a motion without an end, which can be pulled at, or ends it.
    Live,
    /// Shows or hides the values of parameters.
    Values,
    /// Writes changed values into the file.
    Save,
    /// Fits the whole motion into the picture.
    Fit,
    /// Looks at a spatial mechanism from a standard direction.
    Look(StandardView),
    /// Cuts a spatial mechanism across an axis, 0 to 2, or no longer.
    Section(usize),
    /// Moves the section plane by a number of steps.
    MoveSection(i8),
    /// Shows or hides the names of joints and points.
    Labels,
    /// Shows the trails of all points, or hides all trails.
    Trails,
    /// Shows or hides the arrows of joint reactions.
    Reactions,
    /// Shows or hides the arrows of velocities.
    Velocities,
    /// Shows or hides the arrows of applied forces.
    Forces,
    /// Switches between light and dark.
    Theme,
    /// Shows or hides the curves.
    Panel,
    /// Shows or hides the list of keys.
    Help,
    /// Closes the list of keys.
    Dismiss,
    /// Closes the window.
    Quit,
}

/// A key with its action, and its row in the help.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binding {
    /// The key.
    pub(super) key: Key,
    /// Keys held down with it.
    pub(super) modifiers: Modifiers,
    /// Action of the binding.
    pub(super) action: Action,
    /// Name of the key and its action in words; none if another row has them.
    pub(super) help: Option<(&'static str, &'static str)>,
}

const fn key(key: Key, action: Action, name: &'static str, words: &'static str) -> Binding {
    Binding { key, modifiers: Modifiers::NONE, action, help: Some((name, words)) }
}

const fn also(key: Key, modifiers: Modifiers, action: Action) -> Binding {
    Binding { key, modifiers, action, help: None }
}

/// All keys. Those with modifiers come first: the first that fits is taken.
pub(super) const BINDINGS: [Binding; 40] = [
    key(Key::Space, Action::Play, "Space", "play, pause"),
    Binding {
        key: Key::ArrowRight,
        modifiers: Modifiers::SHIFT,
        action: Action::LogStep { is_onward: true },
        help: Some(("Shift + Left, Right", "one step of the integrator")),
    },
    also(Key::ArrowLeft, Modifiers::SHIFT, Action::LogStep { is_onward: false }),
    key(Key::ArrowRight, Action::Frame(1), "Left, Right", "one frame"),
    also(Key::ArrowLeft, Modifiers::NONE, Action::Frame(-1)),
    key(Key::ArrowUp, Action::Speed(1), "Up, Down", "faster, slower"),
    also(Key::ArrowDown, Modifiers::NONE, Action::Speed(-1)),
    also(Key::Plus, Modifiers::NONE, Action::Speed(1)),
    also(Key::Minus, Modifiers::NONE, Action::Speed(-1)),
    key(Key::Num1, Action::RealSpeed, "1", "real time"),
    key(Key::PageUp, Action::Start, "Page Up, Down", "first instant, last instant"),
    also(Key::PageDown, Modifiers::NONE, Action::End),
    key(Key::O, Action::Loop, "O", "go round, or stop at the end"),
    key(Key::M, Action::Live, "M", "a live motion, or its end"),
    key(Key::P, Action::Values, "P", "values of parameters"),
    Binding {
        key: Key::S,
        modifiers: Modifiers::COMMAND,
        action: Action::Save,
        help: Some(("Ctrl + S", "write changed values into the file")),
    },
    key(Key::F, Action::Fit, "F, Home", "fit the whole motion"),
    also(Key::Home, Modifiers::NONE, Action::Fit),
    key(Key::Num2, Action::Look(StandardView::Front), "2, 3, 4, 5", "front, right, top, isometric"),
    also(Key::Num3, Modifiers::NONE, Action::Look(StandardView::Right)),
    also(Key::Num4, Modifiers::NONE, Action::Look(StandardView::Top)),
    also(Key::Num5, Modifiers::NONE, Action::Look(StandardView::Isometric)),
    key(Key::X, Action::Section(0), "X, Y, Z", "cut across the axis, or no longer"),
    also(Key::Y, Modifiers::NONE, Action::Section(1)),
    also(Key::Z, Modifiers::NONE, Action::Section(2)),
    key(Key::OpenBracket, Action::MoveSection(-1), "[, ]", "move the cut"),
    also(Key::CloseBracket, Modifiers::NONE, Action::MoveSection(1)),
    key(Key::L, Action::Labels, "L", "labels"),
    key(Key::T, Action::Trails, "T", "trails of all points"),
    key(Key::R, Action::Reactions, "R", "arrows of joint reactions"),
    key(Key::V, Action::Velocities, "V", "arrows of velocities"),
    key(Key::G, Action::Forces, "G", "arrows of applied forces"),
    key(Key::D, Action::Theme, "D", "light, dark"),
    key(Key::C, Action::Panel, "C", "curves"),
    key(Key::Questionmark, Action::Help, "?", "this list"),
    also(Key::Slash, Modifiers::SHIFT, Action::Help),
    also(Key::F1, Modifiers::NONE, Action::Help),
    also(Key::H, Modifiers::NONE, Action::Help),
    also(Key::Escape, Modifiers::NONE, Action::Dismiss),
    Binding {
        key: Key::Q,
        modifiers: Modifiers::COMMAND,
        action: Action::Quit,
        help: Some(("Ctrl + Q", "close")),
    },
];

/// Actions of the mouse, for the list of keys.
pub(super) const MOUSE: [(&str, &str); 5] = [
    ("drag a body", "pose the mechanism, pull at a live motion"),
    ("drag the rest", "move the picture"),
    ("right drag", "turn a spatial mechanism"),
    ("wheel", "zoom at the pointer"),
    ("click a point", "its trail"),
];

/// The actions of the keys that went down since the last frame; each press is taken once.
pub(super) fn pressed(input: &mut egui::InputState) -> Vec<Action> {
    let mut actions = Vec::new();
    for binding in &BINDINGS {
        while input.consume_key(binding.modifiers, binding.key) {
            actions.push(binding.action);
        }
    }
    actions
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(key: Key, modifiers: Modifiers) -> Vec<Action> {
        let press =
            egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        let mut input = egui::InputState::default();
        input.events.push(press);
        pressed(&mut input)
    }

    #[test]
    fn every_key_has_the_action_of_its_row_and_no_other() {
        for binding in &BINDINGS {
            assert_eq!(press(binding.key, binding.modifiers), [binding.action], "{binding:?}");
        }
        assert_eq!(press(Key::W, Modifiers::NONE), []);
    }

    #[test]
    fn every_action_is_in_the_list_of_keys() {
        for binding in &BINDINGS {
            let same = |other: &&Binding| {
                std::mem::discriminant(&other.action) == std::mem::discriminant(&binding.action)
            };
            let is_listed = BINDINGS.iter().filter(same).any(|other| other.help.is_some());
            let is_obvious = matches!(binding.action, Action::Dismiss | Action::End);
            assert!(is_listed || is_obvious, "{binding:?}");
        }
    }
}
