use sagnac_analysis::deviation::deviations_alone;
use sagnac_analysis::{Deviation, TauGrid, deviations};
use std::time::Instant;
fn cpu() -> f64 { std::fs::read_dir("/proc/self/task").unwrap().map(|t| std::fs::read_to_string(t.unwrap().path().join("schedstat")).unwrap().split_whitespace().next().unwrap().parse::<f64>().unwrap()).sum::<f64>() / 1e9 }
fn main() {
    let mut state = 1_u64;
    let y: Vec<f64> = (0..10_000_000).map(|_| { state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407); (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5 }).collect();
    let f = TauGrid::Default.factors(Deviation::Oadev, y.len(), 0.01);
    let best = |name: &str, run: &mut dyn FnMut()| { let mut b = f64::MAX; let mut c = f64::MAX; for _ in 0..8 { let t = Instant::now(); let u = cpu(); run(); b = b.min(t.elapsed().as_secs_f64()); c = c.min(cpu() - u); } println!("{name} wall {b:.4} cpu {c:.4}"); };
    let groups: Vec<(String, Vec<usize>)> = vec![("phase".into(), vec![]), ("m<=1024".into(), f.iter().copied().filter(|&m| m <= 1024).collect()), ("m<=65536".into(), f.iter().copied().filter(|&m| m > 1024 && m <= 65536).collect()), ("far".into(), f.iter().copied().filter(|&m| m > 65536).collect()), ("all".into(), f.clone())];
    for (n, g) in &groups { best(&format!("{n} {}", g.len()), &mut || { std::hint::black_box(deviations_alone(&[&y], 0.01, Deviation::Oadev, g).unwrap()); }); }
    best("full", &mut || { std::hint::black_box(deviations(&[&y], 0.01, Deviation::Oadev, &TauGrid::Default).unwrap()); });
}
