//! Inertial sensors understood: simulate, characterize, calibrate, correct, grade, drift.
