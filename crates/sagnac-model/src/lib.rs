//! Sensor model files, quantities with units as text, the sensor catalogue and exporters.
