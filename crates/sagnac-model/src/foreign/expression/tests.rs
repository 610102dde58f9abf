//! Covariances as people write them.

use super::gtsam;

fn reads(expression: &str, wanted: &[f64]) {
    let text = format!("v = 2e-3\nI = np.eye(3)\np.setGyroscopeCovariance({expression})\n");
    let flat = gtsam(&text);
    assert!(
        flat.problems.is_empty(),
        "{expression}: {:?}",
        flat.problems
    );
    for (got, want) in flat.items[0].numbers.iter().zip(wanted) {
        assert!((got / want - 1.0).abs() < 1e-12, "{expression}: {got}");
    }
    assert_eq!(flat.items[0].numbers.len(), wanted.len(), "{expression}");
}

#[test]
fn common_ways_to_write_a_covariance_are_read() {
    for expression in [
        "v**2 * np.identity(3)",
        "np.eye(3) * v ** 2",
        "I * 2e-3**2",
        "np.eye(3)*4e-6",
        "4e-6 * I",
        "np.diag([4e-6, 4e-6, 4e-6])",
        "np.diag([v**2] * 3)",
        "np.diag(np.full(3, v**2))",
        "np.diag(np.array([2e-3, 2e-3, 2e-3])**2)",
        "np.power(v, 2) * numpy.eye(3)",
        "pow(v, 2) * np.eye(3)",
        "(v * v) * np.eye(3)",
        "np.array([[4e-6, 0, 0], [0, 4e-6, 0], [0, 0, 4e-6]])",
    ] {
        reads(expression, &[4e-6]);
    }
    reads("np.diag([1e-6, 4e-6, 9e-6])", &[1e-6, 4e-6, 9e-6]);
    reads("I * np.deg2rad(1.0) ** 2 / 4", &[7.615_435_494_667_714e-5]);
}

#[test]
fn cpp_is_read() {
    let code = "#include <gtsam/navigation/CombinedImuFactor.h>\n// p->gyroscopeCovariance = I_3x3;\n\
        const double s = 2e-3;\nvoid f() { auto p = PreintegrationCombinedParams::MakeSharedD(0.0);\n\
        p->accelerometerCovariance = I_3x3 * pow(s, 2.0);\n  p->gyroscopeCovariance = Matrix33::Identity(3, 3) * s * s;\n\
        p->biasAccCovariance = Vector3(1e-6, 2e-6, 3e-6).asDiagonal();\n\
        p->setBiasOmegaCovariance(std::pow(s, 2) * Eigen::Matrix3d::Identity()); }\n";
    let flat = gtsam(code);
    assert!(flat.problems.is_empty(), "{:?}", flat.problems);
    let numbers: Vec<_> = flat.items.iter().map(|item| item.numbers.clone()).collect();
    assert_eq!(
        numbers,
        [vec![4e-6], vec![4e-6], vec![1e-6, 2e-6, 3e-6], vec![4e-6]]
    );
    assert_eq!(flat.items[0].key, "p->accelerometerCovariance");
}

#[test]
fn what_cannot_be_read_is_refused_by_name() {
    for (expression, name) in [
        ("sigma ** 2 * I", "`sigma`"),
        ("make_covariance(v)", "`make_covariance(…)`"),
        ("v ** 2", "a number stands"),
        ("np.eye(2)", "3 x 3"),
        (
            "np.array([[1, 1, 0], [0, 1, 0], [0, 0, 1]])",
            "off its diagonal",
        ),
        ("np.eye(3) * config['v']", "`config`"),
        ("np.eye(3) * (v", ""),
    ] {
        let flat = gtsam(&format!(
            "v = 1\nI = np.eye(3)\np.setGyroscopeCovariance({expression})\n"
        ));
        assert!(flat.items.is_empty(), "{expression}");
        assert!(
            name.is_empty() || flat.problems[0].what.contains(name),
            "{expression}: {:?}",
            flat.problems
        );
    }
}

#[test]
fn lists_of_lists_and_chains_of_names_stay_small() {
    let mut lists = String::from("v0 = [1] * 6\n");
    let mut chain = String::from("w0 = unknown\n");
    for k in 0..2000 {
        lists.push_str(&format!(
            "v{} = [v{k}, v{k}, v{k}, v{k}, v{k}, v{k}]\n",
            k + 1
        ));
        chain.push_str(&format!("w{} = w{k}\n", k + 1));
    }
    let flat = gtsam(&(lists + "p.setGyroscopeCovariance(v2000)\n"));
    assert!(flat.problems[0].what.contains("too long"));
    let flat = gtsam(&(chain + "p.setGyroscopeCovariance(w2000)\n"));
    let what = &flat.problems[0].what;
    assert!(what.contains("`unknown`") && what.len() < 400, "{what}");
}
