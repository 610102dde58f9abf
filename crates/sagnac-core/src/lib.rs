//! The inertial measurement model and its inverse, without std and without heap.
#![no_std]
