//! [`Theme`]: colours of figures.

/// Colours on a background, as `0xrrggbb`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Theme {
    /// Background of the figure.
    pub background: u32,
    /// Words and numbers.
    pub text: u32,
    /// Axes.
    pub axis: u32,
    /// Lines of the grid.
    pub grid: u32,
    /// Curves, one after the other.
    pub palette: [u32; 6],
}

impl Theme {
    /// On white.
    pub const LIGHT: Self = Self {
        background: 0xff_ff_ff,
        text: 0x1f_23_28,
        axis: 0x5c_63_6b,
        grid: 0xe1_e4_e8,
        palette: [0x2f_6f_b5, 0xd9_76_1c, 0x3a_92_5a, 0xa3_52_a0, 0xb8_46_46, 0x4b_98_a3],
    };

    /// On near black.
    pub const DARK: Self = Self {
        background: 0x16_19_1d,
        text: 0xe4_e7_eb,
        axis: 0x9a_a2_ab,
        grid: 0x30_36_3d,
        palette: [0x5a_9b_e0, 0xf0_96_48, 0x5c_bd_80, 0xc8_80_c5, 0xe0_77_77, 0x70_bf_ca],
    };

    /// Colour of the curve of this number.
    pub(crate) fn curve(&self, color: usize) -> u32 {
        self.palette[color % self.palette.len()]
    }
}
