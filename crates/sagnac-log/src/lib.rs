//! Readers and writers of inertial logs, and their health.
