//! One number of every lane as a value. Each operation is a loop of its own over the lanes, which becomes one vector
//! instruction; numbers that pass from step to step then stay in registers.

#![allow(
    clippy::inline_always,
    reason = "becomes vector code only where it is inlined"
)]

use core::ops::{Add, Mul, Neg, Sub};

/// `L` numbers, one a lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lane<const L: usize>(pub(super) [f64; L]);

impl<const L: usize> Lane<L> {
    /// The same number in every lane.
    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Self([x; L])
    }

    #[inline(always)]
    fn map(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        Self(core::array::from_fn(|l| operation(self.0[l], other.0[l])))
    }

    /// 1/x.
    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        Self(self.0.map(|x| 1.0 / x))
    }
}

impl<const L: usize> Add for Lane<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map(other, |a, b| a + b)
    }
}

impl<const L: usize> Sub for Lane<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map(other, |a, b| a - b)
    }
}

impl<const L: usize> Mul for Lane<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.map(other, |a, b| a * b)
    }
}

impl<const L: usize> Mul<Lane<L>> for f64 {
    type Output = Lane<L>;
    #[inline(always)]
    fn mul(self, lane: Lane<L>) -> Lane<L> {
        Lane::all(self) * lane
    }
}

impl<const L: usize> Neg for Lane<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}
