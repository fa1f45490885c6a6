//! [`Theme`]: colours and widths of everything that is drawn.

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

/// How the face is painted at which a section plane cuts a solid.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct SectionPaint {
    /// Colour of the area.
    pub fill: Color,
    /// Line along its edges.
    pub outline: Stroke,
    /// Lines of the hatching.
    pub hatching: Stroke,
}

/// Colours on a background.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Theme {
    /// True if the background is dark.
    pub is_dark: bool,
    /// Background of the picture.
    pub background: Color,
    /// Words.
    pub text: Color,
    /// Secondary words, axes, the grid.
    pub faint: Color,
    /// Areas of bodies, one after the other; curves too.
    pub palette: [Color; 6],
    /// Arrows of reactions.
    pub force: Color,
    /// Arrows of applied forces.
    pub load: Color,
    /// Arrows of velocities.
    pub velocity: Color,
    /// Sizes that do not grow with the mechanism.
    pub sizes: Sizes,
}

/// Sizes in pixels.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Sizes {
    /// Height of letters.
    pub text: f32,
    /// Width of trails.
    pub trail: f32,
    /// Width of the shafts of arrows.
    pub arrow: f32,
    /// Length of the heads of arrows.
    pub head: f32,
    /// Widths of the lines of shapes, as a multiple of the usual ones.
    pub lines: f32,
}

impl Sizes {
    /// For pictures on a screen.
    pub const SCREEN: Self = Self { text: 13.0, trail: 1.8, arrow: 2.0, head: 10.0, lines: 1.0 };
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
        load: Color::opaque(0x8a_3f_b8),
        velocity: Color::opaque(0x1f_8a_4c),
        sizes: Sizes::SCREEN,
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
        load: Color::opaque(0xcf_95_ee),
        velocity: Color::opaque(0x5a_d1_8a),
        sizes: Sizes::SCREEN,
    };

    /// How a role is painted.
    pub fn paint(&self, role: Role) -> Paint {
        let line =
            |color: Color, width: f32| Some(Stroke { color, width: width * self.sizes.lines });
        // A shape hides the ones under it: a tint is opaque.
        let tint =
            |color: Color, opacity: f32| Some(color.with_opacity(opacity).over(self.background));
        let of_palette = |number: u8| self.palette[usize::from(number) % self.palette.len()];
        let (fill, stroke) = match role {
            Role::Ground => (tint(self.faint, 0.25), line(self.text, 1.5)),
            Role::Hatching => (None, line(self.faint, 1.0)),
            Role::Guide => (None, line(self.text, 1.5)),
            Role::Body(number) => {
                let color = of_palette(number);
                (tint(color, 0.35), line(color, 1.8))
            }
            Role::Pin => (Some(self.background), line(self.text, 1.6)),
            Role::Drive => (Some(self.velocity), line(self.velocity, 1.8)),
            Role::Torque => (Some(self.force), line(self.force, 1.8)),
            Role::MassLight => (Some(self.background), line(self.text, 1.0)),
            Role::MassDark | Role::Weld => (Some(self.text), line(self.text, 1.0)),
            Role::Spring | Role::Damper => (None, line(self.text, 1.6)),
            Role::Link => (None, line(self.text, 2.5)),
            Role::Curve(number) => (None, line(of_palette(number + 1), 2.2)),
            Role::FaintCurve(number) => {
                (None, line(of_palette(number + 1).with_opacity(0.5).over(self.background), 1.4))
            }
            Role::Swept(number) => {
                let color = of_palette(number + 1);
                (tint(color, 0.14), line(color.with_opacity(0.6).over(self.background), 1.0))
            }
        };
        Paint { fill, stroke }
    }
}

impl Theme {
    /// How the face is painted at which a section plane cuts a solid of this role: lighter than any of its own
    /// faces, and hatched.
    pub fn section(&self, role: Role) -> SectionPaint {
        let usual = Stroke { color: self.text, width: 1.5 * self.sizes.lines };
        let outline = self.paint(role).stroke.unwrap_or(usual);
        let fill = outline.color.with_opacity(0.1).over(self.background);
        let color = outline.color.with_opacity(0.75).over(self.background);
        SectionPaint { fill, outline, hatching: Stroke { color, width: 0.55 * outline.width } }
    }
}

impl SectionPaint {
    /// Paint this many times as opaque.
    #[must_use]
    pub fn faded(self, factor: f32) -> Self {
        let fade = |stroke: Stroke| Stroke { color: stroke.color.faded(factor), ..stroke };
        let Self { fill, outline, hatching } = self;
        Self { fill: fill.faded(factor), outline: fade(outline), hatching: fade(hatching) }
    }
}

impl Paint {
    /// The colour of a face that is turned away from the light by `shade`, 0 to 1.
    pub fn shaded(&self, shade: f32) -> Option<Color> {
        let dark = self.stroke.map(|stroke| stroke.color.with_opacity(0.6 * shade));
        self.fill.map(|fill| dark.map_or(fill, |dark| dark.over(fill)))
    }

    /// Paint this many times as opaque.
    #[must_use]
    pub fn faded(self, factor: f32) -> Self {
        let fade = |stroke: Stroke| Stroke { color: stroke.color.faded(factor), ..stroke };
        Self { fill: self.fill.map(|fill| fill.faded(factor)), stroke: self.stroke.map(fade) }
    }
}
