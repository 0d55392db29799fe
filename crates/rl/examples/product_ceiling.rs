//! Updates per second beside the rate at which their bare matrix products run in other libraries, in one run:
//! `cargo run --release -p sindyna-rl --example product_ceiling [64|256] [rounds]`.
//!
//! `MKL_RT` names a `libmkl_rt.so` to compare with; without it only the crates `gemm` and `faer` are measured. Every
//! round measures each in turn, and medians are printed: on a shared machine only ratios of one run mean anything.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]
#![expect(unsafe_code, reason = "the libraries compared with take raw pointers")]

use std::time::Instant;

use sindyna_core::{Batch, Seed};
use sindyna_rl::{Isa, Sac, SacConfig, Scaling};

/// C (m, n) = A (m, k) B (k, n); `ta` and `tb` say which lies transposed in memory.
#[derive(Clone, Copy)]
struct Product {
    m: usize,
    k: usize,
    n: usize,
    ta: bool,
    tb: bool,
}

/// The products of an update of SAC on `b` rows, observation 3, action 1, two hidden layers of `h`: those whose result
/// is used, nothing else.
fn products(b: usize, h: usize) -> Vec<Product> {
    let forward = |rows, i, o| Product { m: rows, k: i, n: o, ta: false, tb: false };
    let d_weights = |i, o| Product { m: i, k: b, n: o, ta: true, tb: false };
    let d_inputs = |rows, i, o| Product { m: rows, k: o, n: i, ta: false, tb: true };
    let net = |rows, i, o| [forward(rows, i, h), forward(rows, h, h), forward(rows, h, o)];
    let back = |i, o| [d_weights(h, o), d_inputs(b, h, o), d_weights(h, h), d_inputs(b, h, h), d_weights(i, h)];
    let mut all = net(2 * b, 3, 2).to_vec();
    for _ in 0..2 {
        all.extend(net(b, 4, 1)); // The target.
        all.extend(net(b, 4, 1));
        all.extend(back(4, 1));
        all.extend(net(b, 4, 1)); // The actor's step: back through half the rows.
        all.extend([d_inputs(b / 2, h, 1), d_inputs(b / 2, h, h), d_inputs(b / 2, 1, h)]);
    }
    all.extend(back(3, 2));
    all
}

fn flops(products: &[Product]) -> f64 {
    products.iter().map(|p| 2.0 * (p.m * p.k * p.n) as f64).sum()
}

/// Operands of every product, of their own each, as an update has them.
struct Operands {
    a: Vec<f32>,
    b: Vec<f32>,
    c: Vec<f32>,
}

type Sgemm =
    unsafe extern "C" fn(i32, i32, i32, i32, i32, i32, f32, *const f32, i32, *const f32, i32, f32, *mut f32, i32);

enum Library {
    Gemm,
    Faer,
    Mkl(Sgemm),
}

impl Library {
    fn run(&self, p: Product, o: &mut Operands) {
        let (ars, acs) = if p.ta { (1, p.m as isize) } else { (p.k as isize, 1) };
        let (brs, bcs) = if p.tb { (1, p.k as isize) } else { (p.n as isize, 1) };
        let (a, b, c) = (o.a.as_ptr(), o.b.as_ptr(), o.c.as_mut_ptr());
        // SAFETY: `operands` made each as long as its matrix.
        unsafe {
            match self {
                Self::Gemm => gemm::gemm(
                    p.m,
                    p.n,
                    p.k,
                    c,
                    1,
                    p.n as isize,
                    false,
                    a,
                    acs,
                    ars,
                    b,
                    bcs,
                    brs,
                    0.0,
                    1.0,
                    false,
                    false,
                    false,
                    gemm::Parallelism::None,
                ),
                Self::Faer => faer::linalg::matmul::matmul(
                    faer::MatMut::from_raw_parts_mut(c, p.m, p.n, p.n as isize, 1),
                    faer::Accum::Replace,
                    faer::MatRef::from_raw_parts(a, p.m, p.k, ars, acs),
                    faer::MatRef::from_raw_parts(b, p.k, p.n, brs, bcs),
                    1.0,
                    faer::Par::Seq,
                ),
                Self::Mkl(sgemm) => {
                    let turned = |t| if t { 112 } else { 111 };
                    let (lda, ldb) = (if p.ta { p.m } else { p.k }, if p.tb { p.k } else { p.n });
                    let [m, n, k, lda, ldb, ldc] = [p.m, p.n, p.k, lda, ldb, p.n].map(|v| v as i32);
                    sgemm(101, turned(p.ta), turned(p.tb), m, n, k, 1.0, a, lda, b, ldb, 0.0, c, ldc);
                }
            }
        }
    }
}

/// MKL's product, held to one thread.
fn mkl() -> Result<Option<Sgemm>, Box<dyn std::error::Error>> {
    let Some(path) = std::env::var_os("MKL_RT") else { return Ok(None) };
    // SAFETY: the library is the user's choice; both symbols have these signatures in every MKL (LP64).
    unsafe {
        let library = Box::leak(Box::new(libloading::Library::new(path)?));
        library.get::<unsafe extern "C" fn(i32)>(b"MKL_Set_Num_Threads\0")?(1);
        Ok(Some(*library.get::<Sgemm>(b"cblas_sgemm\0")?))
    }
}

fn operands(products: &[Product]) -> Vec<Operands> {
    let wave = |n: usize| (0..n).map(|i| (1.7 * i as f32).sin()).collect();
    products.iter().map(|p| Operands { a: wave(p.m * p.k), b: wave(p.k * p.n), c: wave(p.m * p.n) }).collect()
}

fn batch() -> Batch {
    let mut batch = Batch::zeros(256, 3, 1);
    batch.observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
    batch.next_observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64 + 0.1).sin());
    batch.actions.iter_mut().enumerate().for_each(|(i, v)| *v = 2.0 * (3.0 * i as f64).sin());
    batch.rewards.iter_mut().enumerate().for_each(|(i, v)| *v = (7.0 * i as f64).cos());
    batch
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let wanted: Option<usize> = arguments.next().map(|w| w.parse()).transpose()?;
    let rounds: usize = arguments.next().map_or(Ok(200), |n| n.parse())?;
    for (width, window) in [(64, 5), (256, 1)] {
        if wanted.is_some_and(|w| w != width) {
            continue;
        }
        let mut rng = Seed::new(0).stream("benchmark", 0);
        let config = SacConfig { hidden: vec![width, width], ..SacConfig::default() };
        let sac = Sac::new(config, Scaling::identity(3), &[-2.0], &[2.0], &mut rng)?;
        let batch = batch();
        let mut agents = Vec::new();
        for isa in Isa::ALL.into_iter().rev() {
            agents.extend(sac.clone().with_isa(isa));
        }
        let products = products(256, width);
        let mut operands = operands(&products);
        let mut libraries = vec![("gemm", Library::Gemm), ("faer", Library::Faer)];
        libraries.extend(mkl()?.map(|sgemm| ("MKL", Library::Mkl(sgemm))));

        let mut names: Vec<String> = agents.iter().map(|a| format!("update, {}", a.isa())).collect();
        names.extend(libraries.iter().map(|(name, _)| format!("products alone, {name}")));
        let mut rates = vec![Vec::new(); names.len()];
        for round in 0..=rounds {
            let mut rates = rates.iter_mut();
            let mut note = |start: Instant| {
                let rate = f64::from(window) / start.elapsed().as_secs_f64();
                // The first round warms up.
                if let (Some(rates), true) = (rates.next(), round > 0) {
                    rates.push(rate);
                }
            };
            for agent in &mut agents {
                let start = Instant::now();
                for _ in 0..window {
                    agent.update(&batch, &mut rng)?;
                }
                note(start);
            }
            for (_, library) in &libraries {
                let start = Instant::now();
                for _ in 0..window {
                    products.iter().zip(&mut operands).for_each(|(p, o)| library.run(*p, o));
                }
                note(start);
            }
        }
        println!("{width}x{width}, batch 256, {:.1} MFLOP per update", flops(&products) / 1e6);
        let medians: Vec<f64> = rates.iter_mut().map(|r| median(r)).collect();
        let ceiling = medians[agents.len()..].iter().copied().fold(0.0, f64::max);
        for ((name, median), rates) in names.iter().zip(&medians).zip(&rates) {
            let (best, share) = (rates.last().copied().unwrap_or(f64::NAN), 100.0 * median / ceiling);
            let speed = median * flops(&products) / 1e9;
            println!(
                "{name:24} {median:7.0}/s (best {best:7.0}), {speed:4.0} GFLOP/s, {share:4.0} % of the fastest products"
            );
        }
    }
    Ok(())
}
