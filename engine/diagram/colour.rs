//! Colours: sRGB as they are stored, linear as light adds up, and the palette of every picture.

/// A colour as it is stored: sRGB-encoded, 8 bits a channel, alpha not multiplied in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    /// Red, green and blue, sRGB-encoded.
    pub rgb: [u8; 3],
    /// 0 is transparent, 255 opaque.
    pub alpha: u8,
}

impl Colour {
    /// An opaque colour from `0xRRGGBB`, sRGB-encoded.
    pub const fn hex(code: u32) -> Self {
        let [_, red, green, blue] = code.to_be_bytes();
        Self { rgb: [red, green, blue], alpha: 255 }
    }

    /// The same colour with another alpha.
    pub const fn with_alpha(self, alpha: u8) -> Self {
        Self { alpha, ..self }
    }

    /// An opaque colour from linear light in [0, 1]; what lies outside is clamped, NaN is black.
    pub fn from_linear(linear: [f32; 3]) -> Self {
        Self { rgb: linear.map(encode), alpha: 255 }
    }

    /// Red, green and blue as linear light in [0, 1].
    pub fn to_linear(self) -> [f32; 3] {
        self.rgb.map(decode)
    }

    /// The colour a part `t` in [0, 1] of the way to `other`, mixed as linear light.
    #[must_use]
    pub fn mix(self, other: Self, t: f32) -> Self {
        let (from, to) = (self.to_linear(), other.to_linear());
        Self::from_linear([0, 1, 2].map(|i| from[i] + t * (to[i] - from[i])))
    }
}

/// Linear light to an 8-bit sRGB channel (IEC 61966-2-1).
pub fn encode(linear: f32) -> u8 {
    encode_above(linear, 0.5)
}

/// Linear light to an 8-bit sRGB channel that is rounded up where more than the part `threshold` of
/// a step remains.
pub(super) fn encode_above(linear: f32, threshold: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    // The cast cuts off, ends at 255, and makes NaN zero.
    (encoded * 255.0 + 1.0 - threshold) as u8
}

/// An 8-bit sRGB channel to linear light in [0, 1] (IEC 61966-2-1).
pub fn decode(channel: u8) -> f32 {
    let encoded = f32::from(channel) / 255.0;
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The colours that every picture of the engine shares.
pub mod palette {
    use super::Colour;

    /// The page.
    pub const PAPER: Colour = Colour::hex(0xff_ff_ff);
    /// Text and frames.
    pub const INK: Colour = Colour::hex(0x22_26_2b);
    /// Secondary text, ticks and guides.
    pub const SLATE: Colour = Colour::hex(0x6a_72_7c);
    /// Grids.
    pub const MIST: Colour = Colour::hex(0xe3_e6_ea);
    /// Surfaces.
    pub const CLAY: Colour = Colour::hex(0xd6_d3_cd);
    /// Values that are missing.
    pub const MISSING: Colour = Colour::hex(0x9a_9a_9a);
    /// The first series; control cages.
    pub const BLUE: Colour = Colour::hex(0x1f_5a_96);
    /// The second series; given curves.
    pub const RED: Colour = Colour::hex(0xc2_4d_35);
    /// The third series.
    pub const GREEN: Colour = Colour::hex(0x3d_84_62);
    /// The fourth series.
    pub const OCHRE: Colour = Colour::hex(0xc8_93_2b);
    /// The fifth series.
    pub const PLUM: Colour = Colour::hex(0x75_55_8c);
    /// The sixth series.
    pub const TEAL: Colour = Colour::hex(0x3a_95_a6);

    /// One for each series, in order; they differ in lightness too, so that they survive a grey printer.
    pub const SERIES: [Colour; 6] = [BLUE, RED, GREEN, OCHRE, PLUM, TEAL];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_survives_the_way_to_light_and_back() {
        for channel in 0..=255 {
            assert_eq!(encode(decode(channel)), channel);
        }
    }

    #[test]
    fn light_outside_its_range_is_clamped() {
        assert_eq!([-1.0, f32::NAN, f32::NEG_INFINITY].map(encode), [0; 3]);
        assert_eq!([1.5, f32::INFINITY].map(encode), [255; 2]);
    }

    /// Half of the light is far above half of the code: mixing happens in linear light.
    #[test]
    fn black_and_white_mix_to_half_the_light() {
        let grey = Colour::hex(0).mix(Colour::hex(0xff_ff_ff), 0.5);
        assert_eq!(grey, Colour::hex(0xbc_bc_bc));
    }
}
