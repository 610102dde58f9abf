//! The catalogue's files by name. Made by `tools/catalogue.py`; do not edit.

/// Name as printed, and the text of the model file.
pub(super) const FILES: [(&str, &str); 73] = [
    ("1750 IMU", include_str!("../../catalogue/1750-imu.toml")),
    (
        "3DM-GX3-35",
        include_str!("../../catalogue/3dm-gx3-35.toml"),
    ),
    (
        "3DM-GX5-25",
        include_str!("../../catalogue/3dm-gx5-25.toml"),
    ),
    ("ADIS16405", include_str!("../../catalogue/adis16405.toml")),
    ("ADIS16407", include_str!("../../catalogue/adis16407.toml")),
    ("ADIS16448", include_str!("../../catalogue/adis16448.toml")),
    ("ADIS16460", include_str!("../../catalogue/adis16460.toml")),
    ("ADIS16465", include_str!("../../catalogue/adis16465.toml")),
    (
        "ADIS16467-1",
        include_str!("../../catalogue/adis16467-1.toml"),
    ),
    ("ADIS16470", include_str!("../../catalogue/adis16470.toml")),
    ("ADIS16475", include_str!("../../catalogue/adis16475.toml")),
    (
        "ADIS16475-2",
        include_str!("../../catalogue/adis16475-2.toml"),
    ),
    ("ADIS16488", include_str!("../../catalogue/adis16488.toml")),
    (
        "ADIS16488A",
        include_str!("../../catalogue/adis16488a.toml"),
    ),
    (
        "ADIS16495-1",
        include_str!("../../catalogue/adis16495-1.toml"),
    ),
    (
        "ADIS16497-1",
        include_str!("../../catalogue/adis16497-1.toml"),
    ),
    (
        "ADIS16505-1",
        include_str!("../../catalogue/adis16505-1.toml"),
    ),
    (
        "Astrix 200",
        include_str!("../../catalogue/astrix-200.toml"),
    ),
    ("BMI088", include_str!("../../catalogue/bmi088.toml")),
    ("BMI160", include_str!("../../catalogue/bmi160.toml")),
    ("BMI270", include_str!("../../catalogue/bmi270.toml")),
    (
        "cold-atom accelerometer triad",
        include_str!("../../catalogue/cold-atom-accelerometer-triad.toml"),
    ),
    ("DMU30-01", include_str!("../../catalogue/dmu30-01.toml")),
    ("H-764G", include_str!("../../catalogue/h-764g.toml")),
    (
        "HG1700-AG58",
        include_str!("../../catalogue/hg1700-ag58.toml"),
    ),
    (
        "HG1700-AG59",
        include_str!("../../catalogue/hg1700-ag59.toml"),
    ),
    (
        "HG1700-AG60",
        include_str!("../../catalogue/hg1700-ag60.toml"),
    ),
    (
        "HG1700-AG61",
        include_str!("../../catalogue/hg1700-ag61.toml"),
    ),
    (
        "HG1700-AG71",
        include_str!("../../catalogue/hg1700-ag71.toml"),
    ),
    ("HG4930", include_str!("../../catalogue/hg4930.toml")),
    (
        "HG5700-AA01",
        include_str!("../../catalogue/hg5700-aa01.toml"),
    ),
    (
        "HG5700-BA01",
        include_str!("../../catalogue/hg5700-ba01.toml"),
    ),
    (
        "HG5700-CA01",
        include_str!("../../catalogue/hg5700-ca01.toml"),
    ),
    ("HG9900", include_str!("../../catalogue/hg9900.toml")),
    (
        "HGuide i300",
        include_str!("../../catalogue/hguide-i300.toml"),
    ),
    ("ICM-20602", include_str!("../../catalogue/icm-20602.toml")),
    ("ICM-20649", include_str!("../../catalogue/icm-20649.toml")),
    ("ICM-20948", include_str!("../../catalogue/icm-20948.toml")),
    (
        "ICM-42688-P",
        include_str!("../../catalogue/icm-42688-p.toml"),
    ),
    ("IIM-42653", include_str!("../../catalogue/iim-42653.toml")),
    ("iIMU-FSAS", include_str!("../../catalogue/iimu-fsas.toml")),
    (
        "iPhone XR internal IMU",
        include_str!("../../catalogue/iphone-xr-internal-imu.toml"),
    ),
    ("LN-200", include_str!("../../catalogue/ln-200.toml")),
    ("LN-200S", include_str!("../../catalogue/ln-200s.toml")),
    ("LSM6DSO", include_str!("../../catalogue/lsm6dso.toml")),
    (
        "M-G362PDC1",
        include_str!("../../catalogue/m-g362pdc1.toml"),
    ),
    (
        "M-G370PDS0",
        include_str!("../../catalogue/m-g370pds0.toml"),
    ),
    ("MOTUS", include_str!("../../catalogue/motus.toml")),
    (
        "MPC-MEMS-IRU",
        include_str!("../../catalogue/mpc-mems-iru.toml"),
    ),
    ("MPU-6050", include_str!("../../catalogue/mpu-6050.toml")),
    ("MPU-6500", include_str!("../../catalogue/mpu-6500.toml")),
    ("MPU-9250", include_str!("../../catalogue/mpu-9250.toml")),
    (
        "MS-IMU3050",
        include_str!("../../catalogue/ms-imu3050.toml"),
    ),
    ("NAV440", include_str!("../../catalogue/nav440.toml")),
    (
        "OpenRTK330 / 300ZA",
        include_str!("../../catalogue/openrtk330-300za.toml"),
    ),
    (
        "Primus 200",
        include_str!("../../catalogue/primus-200.toml"),
    ),
    ("Pulse-40", include_str!("../../catalogue/pulse-40.toml")),
    ("QA-2000", include_str!("../../catalogue/qa-2000.toml")),
    ("RPU30", include_str!("../../catalogue/rpu30.toml")),
    (
        "SCH16T-K01",
        include_str!("../../catalogue/sch16t-k01.toml"),
    ),
    ("SiIMU02", include_str!("../../catalogue/siimu02.toml")),
    ("STIM202", include_str!("../../catalogue/stim202.toml")),
    ("STIM210", include_str!("../../catalogue/stim210.toml")),
    ("STIM300", include_str!("../../catalogue/stim300.toml")),
    ("STIM377H", include_str!("../../catalogue/stim377h.toml")),
    ("VN-100", include_str!("../../catalogue/vn-100.toml")),
    ("VN-200", include_str!("../../catalogue/vn-200.toml")),
    ("VN-310", include_str!("../../catalogue/vn-310.toml")),
    (
        "Xsens MTi-1",
        include_str!("../../catalogue/xsens-mti-1.toml"),
    ),
    (
        "Xsens MTi-10",
        include_str!("../../catalogue/xsens-mti-10.toml"),
    ),
    (
        "Xsens MTi-3",
        include_str!("../../catalogue/xsens-mti-3.toml"),
    ),
    (
        "Xsens MTi-300",
        include_str!("../../catalogue/xsens-mti-300.toml"),
    ),
    (
        "Xsens MTi-630",
        include_str!("../../catalogue/xsens-mti-630.toml"),
    ),
];
