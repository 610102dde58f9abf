//! Exact discrete generators of every random error of an inertial sensor.
#![no_std]
