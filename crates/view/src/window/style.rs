//! Colours and spacing of the window around the picture, made from the theme of the picture.

use bksim_scene::Theme;
use egui::{Color32, CornerRadius, FontFamily, FontId, Stroke, TextStyle, Visuals};

use super::options::Look;
use super::said;
pub(super) use crate::words::color32;

/// The theme of the picture in a light or dark window.
pub(super) fn theme(is_dark: bool) -> &'static Theme {
    if is_dark { &Theme::DARK } else { &Theme::LIGHT }
}

/// Colour of controls that are on, of the playing position, and of the point under the pointer.
pub(super) fn accent(theme: &Theme) -> Color32 {
    color32(theme.palette[0])
}

/// Gives both themes of the window their look, and the window one of them.
pub(super) fn set(context: &egui::Context, look: Look) {
    said::load_letters(context);
    context.options_mut(|options| options.fallback_theme = egui::Theme::Light);
    context.set_theme(match look {
        Look::System => egui::ThemePreference::System,
        Look::Light => egui::ThemePreference::Light,
        Look::Dark => egui::ThemePreference::Dark,
    });
    for (which, is_dark) in [(egui::Theme::Light, false), (egui::Theme::Dark, true)] {
        context.set_visuals_of(which, visuals(theme(is_dark)));
    }
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 6.0);
        style.spacing.button_padding = egui::vec2(8.0, 4.0);
        style.spacing.interact_size.y = 26.0;
        style.spacing.menu_margin = egui::Margin::same(8);
        style.animation_time = 0.1;
        let size = |size: f32| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Body, size(13.5));
        style.text_styles.insert(TextStyle::Button, size(13.5));
        style.text_styles.insert(TextStyle::Small, size(11.5));
        style.text_styles.insert(TextStyle::Heading, size(16.0));
        let monospace = FontId::new(12.5, FontFamily::Monospace);
        style.text_styles.insert(TextStyle::Monospace, monospace);
    });
}

/// Switches between light and dark.
pub(super) fn toggle_theme(context: &egui::Context) {
    let is_dark = context.theme() == egui::Theme::Dark;
    context.set_theme(if is_dark { egui::Theme::Light } else { egui::Theme::Dark });
}

/// The colours of the window around a picture with this theme.
fn visuals(theme: &Theme) -> Visuals {
    let mut visuals = if theme.is_dark { Visuals::dark() } else { Visuals::light() };
    let (text, faint) = (color32(theme.text), color32(theme.faint));
    let tint = |opacity: f32| color32(theme.text.with_opacity(opacity));
    // Panels are a shade off the picture, so that it stands out.
    let panel = if theme.is_dark {
        Color32::from_rgb(0x1d, 0x21, 0x27)
    } else {
        Color32::from_rgb(0xf5, 0xf6, 0xf8)
    };
    visuals.panel_fill = panel;
    visuals.window_fill = panel;
    visuals.extreme_bg_color = color32(theme.background);
    visuals.faint_bg_color = tint(0.04);
    visuals.window_stroke = Stroke::new(1.0, tint(0.16));
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(8);
    visuals.selection.bg_fill = color32(theme.palette[0].with_opacity(0.35));
    visuals.selection.stroke = Stroke::new(1.0, text);
    visuals.error_fg_color = color32(theme.force);
    visuals.weak_text_color = Some(faint);
    visuals.slider_trailing_fill = true;

    // Widgets are tints of the text.
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, text);
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, tint(0.12));
    for (widget, fill) in [
        (&mut widgets.inactive, 0.06),
        (&mut widgets.hovered, 0.12),
        (&mut widgets.active, 0.2),
        (&mut widgets.open, 0.12),
    ] {
        widget.fg_stroke = Stroke::new(1.2, text);
        widget.weak_bg_fill = tint(fill);
        widget.bg_fill = tint(fill);
        widget.bg_stroke = Stroke::NONE;
        widget.corner_radius = CornerRadius::same(5);
        widget.expansion = 0.0;
    }
    visuals
}
