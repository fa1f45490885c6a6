//! The bar at the bottom: the slider of time, and the buttons.

use egui::{Align, Layout, Rect, RichText, Sense, Ui, pos2, vec2};

use super::action::Action;
use super::choices::{Choices, moving};
use super::clock::{Clock, SPEEDS};
use super::icon::{self, Icon};
use super::said::said;
use super::{cutting, number, style};
use bksim_scene::{Scene, StandardView};

/// Height of the slider of time, points.
const SCRUB: f32 = 20.0;

/// Width below which the buttons take two rows, points.
const WIDE: f32 = 640.0;

/// Switches of the bar that are on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Switches {
    /// The panel of curves is open.
    pub(super) curves: bool,
    /// The panel of values is open.
    pub(super) values: bool,
    /// A live motion goes on.
    pub(super) live: bool,
}

/// Shows the bar; the actions of its buttons are added to `actions`.
pub(super) fn show(
    ui: &mut Ui,
    clock: &mut Clock,
    choices: &mut Choices,
    scene: Option<&Scene>,
    switches: Switches,
    actions: &mut Vec<Action>,
) {
    scrub_bar(ui, clock);
    let is_wide = ui.available_width() >= WIDE;
    ui.horizontal(|ui| {
        transport(ui, clock, actions);
        if is_wide {
            time(ui, clock);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                tools(ui, clock, choices, scene, switches, actions);
            });
        } else {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| time(ui, clock));
        }
    });
    if !is_wide {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            tools(ui, clock, choices, scene, switches, actions);
        });
    }
}

/// The slider from the first to the last instant; a click or a drag moves the clock.
fn scrub_bar(ui: &mut Ui, clock: &mut Clock) {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), SCRUB), Sense::click_and_drag());
    let rail = Rect::from_center_size(rect.center(), vec2(rect.width() - 12.0, 4.0));
    let part_at = |x: f32| f64::from((x - rail.left()) / rail.width().max(1.0));
    if let Some(pointer) = response.interact_pointer_pos() {
        clock.seek_part(part_at(pointer.x).clamp(0.0, 1.0));
    }
    let accent = style::accent(style::theme(ui.visuals().dark_mode));
    let empty = ui.visuals().widgets.active.bg_fill;
    #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
    let x = rail.left() + rail.width() * clock.part() as f32;
    let painter = ui.painter();
    painter.rect_filled(rail, 2.0, empty);
    painter.rect_filled(Rect::from_min_max(rail.min, pos2(x, rail.max.y)), 2.0, accent);
    let is_held = response.hovered() || response.dragged();
    painter.circle_filled(pos2(x, rail.center().y), if is_held { 7.0 } else { 6.0 }, accent);

    let kind = egui::Role::Slider;
    response.widget_info(|| egui::WidgetInfo::labeled(kind, true, said("time")));
    if let Some(pointer) = response.hover_pos() {
        let [first, last] = clock.span();
        let t = first + part_at(pointer.x).clamp(0.0, 1.0) * (last - first);
        let decimals = number::decimals(clock.span());
        response.on_hover_text_at_pointer(format!("{t:.decimals$} s"));
    }
}

/// Buttons to play and to step.
fn transport(ui: &mut Ui, clock: &Clock, actions: &mut Vec<Action>) {
    ui.spacing_mut().item_spacing.x = 2.0;
    let (play, words) = if clock.is_playing() {
        (Icon::Pause, "pause (Space)")
    } else {
        (Icon::Play, "play (Space)")
    };
    for (icon, is_on, words, action) in [
        (Icon::Start, false, "to the start (Page Up)", Action::Start),
        (Icon::FrameBack, false, "one frame back (Left)", Action::Frame(-1)),
        (play, false, words, Action::Play),
        (Icon::FrameOn, false, "one frame on (Right)", Action::Frame(1)),
        (Icon::Loop, clock.is_looping, "go round at the end (O)", Action::Loop),
    ] {
        if icon::button(ui, icon, is_on, words).clicked() {
            actions.push(action);
        }
    }
}

/// The instant shown, and the last one.
fn time(ui: &mut Ui, clock: &Clock) {
    ui.add_space(8.0);
    let decimals = number::decimals(clock.span());
    let [_, last] = clock.span();
    let last = format!("{last:.decimals$}");
    // As wide as the last instant, so that nothing next to it moves.
    let text = format!("{:>width$.decimals$} / {last} s", clock.t(), width = last.len());
    ui.label(RichText::new(text).monospace());
}

/// All other buttons, from the right to the left.
fn tools(
    ui: &mut Ui,
    clock: &mut Clock,
    choices: &mut Choices,
    scene: Option<&Scene>,
    switches: Switches,
    actions: &mut Vec<Action>,
) {
    for (icon, is_on, words, action) in [
        (Icon::Curves, switches.curves, "curves (C)", Action::Panel),
        (Icon::Help, false, "keys (?)", Action::Help),
        (Icon::Fit, false, "fit the whole motion (F)", Action::Fit),
    ] {
        if icon::button(ui, icon, is_on, words).clicked() {
            actions.push(action);
        }
    }
    for (words, is_on, help, action) in [
        ("Values", switches.values, "values of parameters (P)", Action::Values),
        ("Live", switches.live, "let it move, and pull at it (M)", Action::Live),
    ] {
        if ui.selectable_label(is_on, said(words)).on_hover_text(said(help)).clicked() {
            actions.push(action);
        }
    }
    ui.menu_button(said("Show"), |ui| show_menu(ui, choices, scene, actions))
        .response
        .on_hover_text(said("labels, arrows, trails, light and dark"));
    if scene.is_some_and(|scene| !scene.is_planar) {
        ui.menu_button(said("View"), |ui| {
            for (view, key) in StandardView::ALL.into_iter().zip(["2", "3", "4", "5"]) {
                ui.horizontal(|ui| {
                    if ui.button(said(view.word())).clicked() {
                        actions.push(Action::Look(view));
                        ui.close();
                    }
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        ui.weak(key);
                    });
                });
            }
        })
        .response
        .on_hover_text(said("front, right, top, isometric (2, 3, 4, 5)"));
        ui.menu_button(said("Section"), |ui| cutting::menu(ui, &mut choices.cutting, actions))
            .response
            .on_hover_text(said("cut by a plane (X, Y, Z)"));
    }
    ui.menu_button(RichText::new(number::speed(clock.speed())), |ui| {
        for factor in SPEEDS.into_iter().rev() {
            let is_now = factor == clock.speed();
            if ui.selectable_label(is_now, number::speed(factor)).clicked() {
                clock.set_speed(factor);
                ui.close();
            }
        }
    })
    .response
    .on_hover_text(said("speed (Up, Down)"));
}

/// The menu of additions, and of the points that can leave trails.
fn show_menu(ui: &mut Ui, choices: &mut Choices, scene: Option<&Scene>, actions: &mut Vec<Action>) {
    ui.set_width(200.0);
    let switches = [
        ("Labels", "L", choices.labels, Action::Labels),
        ("Joint reactions", "R", choices.reactions, Action::Reactions),
        ("Velocities", "V", choices.velocities, Action::Velocities),
        ("Applied forces", "G", choices.forces, Action::Forces),
        ("Trails of all points", "T", !choices.trails.is_empty(), Action::Trails),
        ("Dark", "D", ui.visuals().dark_mode, Action::Theme),
    ];
    for (words, key, mut is_on, action) in switches {
        ui.horizontal(|ui| {
            if ui.checkbox(&mut is_on, said(words)).changed() {
                actions.push(action);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.weak(key);
            });
        });
    }
    let Some(scene) = scene else { return };
    ui.separator();
    ui.menu_button(said("Trail of …"), |ui| {
        let names: Vec<&str> = moving(scene).collect();
        let height = ui.text_style_height(&egui::TextStyle::Body) + 6.0;
        egui::ScrollArea::vertical().max_height(260.0).show_rows(
            ui,
            height,
            names.len(),
            |ui, rows| {
                for name in &names[rows] {
                    let mut is_on = choices.trails.contains(*name);
                    if ui.checkbox(&mut is_on, *name).changed() {
                        choices.toggle_trail(name);
                    }
                }
            },
        );
    });
}
