//! [`Theme`]: what colour and width everything has.

use serde::Serialize;

use crate::{Color, Role, Stroke};

/// How a shape is painted.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize)]
pub struct Paint {
    /// Colour of the area, if it is filled.
    pub fill: Option<Color>,
    /// Line along its edges, if there is one.
    pub stroke: Option<Stroke>,
}

/// Colours on a background.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Theme {
    /// Whether the background is dark.
    pub is_dark: bool,
    /// Behind everything.
    pub background: Color,
    /// Words.
    pub text: Color,
    /// Quiet words, axes, the grid.
    pub faint: Color,
    /// Areas of bodies, one after the other; curves too.
    pub palette: [Color; 6],
    /// Arrows of reactions and of applied forces.
    pub force: Color,
    /// Arrows of velocities.
    pub velocity: Color,
}

impl Theme {
    /// On white.
    pub const LIGHT: Self = Self {
        is_dark: false,
        background: Color::opaque(0xff_ff_ff),
        text: Color::opaque(0x1f_23_28),
        faint: Color::opaque(0x8a_91_99),
        palette: [
            Color::opaque(0x2f_6f_b5),
            Color::opaque(0xd9_76_1c),
            Color::opaque(0x3a_92_5a),
            Color::opaque(0xa3_52_a0),
            Color::opaque(0xb8_46_46),
            Color::opaque(0x4b_98_a3),
        ],
        force: Color::opaque(0xc4_27_27),
        velocity: Color::opaque(0x1f_8a_4c),
    };

    /// On near black.
    pub const DARK: Self = Self {
        is_dark: true,
        background: Color::opaque(0x16_19_1d),
        text: Color::opaque(0xe4_e7_eb),
        faint: Color::opaque(0x7b_84_8e),
        palette: [
            Color::opaque(0x5a_9b_e0),
            Color::opaque(0xf0_96_48),
            Color::opaque(0x5c_bd_80),
            Color::opaque(0xc8_80_c5),
            Color::opaque(0xe0_77_77),
            Color::opaque(0x70_bf_ca),
        ],
        force: Color::opaque(0xff_6b_5e),
        velocity: Color::opaque(0x5a_d1_8a),
    };

    /// How a role is painted.
    pub fn paint(&self, role: Role) -> Paint {
        let line = |color: Color, width: f32| Some(Stroke { color, width });
        let (fill, stroke) = match role {
            Role::Ground => (Some(self.faint.with_opacity(0.25)), line(self.text, 1.5)),
            Role::Hatching => (None, line(self.faint, 1.2)),
            Role::Guide => (None, line(self.faint, 2.0)),
            Role::Body(number) => {
                let color = self.palette[usize::from(number) % self.palette.len()];
                (Some(color.with_opacity(0.35)), line(color, 2.0))
            }
            Role::Pin => (Some(self.background), line(self.text, 2.0)),
            Role::MassLight => (Some(self.background), line(self.text, 1.0)),
            Role::MassDark => (Some(self.text), None),
            Role::Spring | Role::Damper => (None, line(self.text, 1.8)),
            Role::Link => (None, line(self.text, 2.5)),
        };
        Paint { fill, stroke }
    }
}
