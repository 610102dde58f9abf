//! Misalignment: Δf_z = m_zx f_x + m_zy f_y, and so on round the axes.
//!
//! The sense axis leans from its nominal direction: the off-diagonal elements of M.
//! Lecture slide 6; IEEE Std 528, "misalignment".

use crate::{Element, Real, vector::Vector};

/// Six elements off the diagonal, row (sense axis) first.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct OffDiagonal<T> {
    /// What axis x senses of y.
    pub xy: T,
    /// What axis x senses of z.
    pub xz: T,
    /// What axis y senses of x.
    pub yx: T,
    /// What axis y senses of z.
    pub yz: T,
    /// What axis z senses of x.
    pub zx: T,
    /// What axis z senses of y.
    pub zy: T,
}

impl<T: Real> OffDiagonal<T> {
    /// From the order of [`Element::ALL`]: xy, xz, yx, yz, zx, zy.
    pub const fn from_array(m: [T; 6]) -> Self {
        let [xy, xz, yx, yz, zx, zy] = m;
        Self {
            xy,
            xz,
            yx,
            yz,
            zx,
            zy,
        }
    }

    /// In the order of [`Element::ALL`].
    pub const fn to_array(&self) -> [T; 6] {
        [self.xy, self.xz, self.yx, self.yz, self.zx, self.zy]
    }

    /// One element.
    pub const fn get(&self, element: Element) -> T {
        match element {
            Element::Xy => self.xy,
            Element::Xz => self.xz,
            Element::Yx => self.yx,
            Element::Yz => self.yz,
            Element::Zx => self.zx,
            Element::Zy => self.zy,
        }
    }

    /// The sum, element by element.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yx: self.yx + other.yx,
            yz: self.yz + other.yz,
            zx: self.zx + other.zx,
            zy: self.zy + other.zy,
        }
    }

    /// What the elements add to each axis for an input u.
    #[inline(always)]
    pub fn part(&self, u: Vector<T>) -> Vector<T> {
        [
            self.xy * u[1] + self.xz * u[2],
            self.yx * u[0] + self.yz * u[2],
            self.zx * u[0] + self.zy * u[1],
        ]
    }
}

/// The misalignment of a triad, rad.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.accel.misalignment.elements.zx = 1e-3;
/// let truth = Truth { specific_force: [5.0, 0.0, -10.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).accel, [5.0, 0.0, -9.995]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Misalignment<T> {
    /// m_xy … m_zy.
    pub elements: OffDiagonal<T>,
}
