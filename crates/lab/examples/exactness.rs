//! How often the equations found are the true ones.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement, not a program")]
use sindyna_core::{Dataset, Environment, Explorer, Region, Seed, VectorField};
use sindyna_dyna::{Alternating, Uniform};
use sindyna_sindy::Identifier;

fn collect(name: &str, steps: usize, seed: u64, explorer: &str) -> (Dataset, usize) {
    let system = sindyna_envs::find(name)
        .or_else(|| sindyna_envs::find_field(name))
        .unwrap()
        .with_noise(std::env::var("NOISE").map_or(0.0, |v| v.parse().unwrap()));
    let spec = system.spec().clone();
    let mut env = system.environment();
    let mut rng = Seed::new(seed).stream("real system", 0);
    let mut explorer: Box<dyn Explorer> = match explorer {
        "alternating" => Box::new(Alternating::new(&spec, 0.2)),
        "swings" => Box::new(sindyna_dyna::Swings::new(&spec)),
        "random" => Box::new(Uniform::new(&spec)),
        _ => panic!(),
    };
    let space = spec.action_space.clone();
    let mut data = Dataset::new(spec.observation_dim(), spec.control_dim(), space.action_dim(), spec.dt);
    let (mut a, mut u) = (vec![0.0; space.action_dim()], vec![0.0; space.control_dim()]);
    let mut running = false;
    for _ in 0..steps {
        if !running {
            env.reset(&mut rng).unwrap();
            data.begin(env.observation()).unwrap();
        }
        explorer.next(&data, &mut rng, &mut a);
        let o = env.step(&a, &mut rng).unwrap();
        space.control_into(&a, &mut u);
        data.push(&a, &u, o.reward, env.observation()).unwrap();
        running = !(o.terminated || o.truncated);
        if !running {
            data.finish(if o.terminated { sindyna_core::End::Terminated } else { sindyna_core::End::Truncated });
        }
    }
    let resets = data.n_rollouts();
    (data, resets)
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (name, steps, first, last, explorer) = (
        &args[1],
        args[2].parse::<usize>().unwrap(),
        args[3].parse::<u64>().unwrap(),
        args[4].parse::<u64>().unwrap(),
        args[5].clone(),
    );
    let system = sindyna_envs::find(name)
        .or_else(|| sindyna_envs::find_field(name))
        .unwrap()
        .with_noise(std::env::var("NOISE").map_or(0.0, |v| v.parse().unwrap()));
    let spec = system.spec().clone();
    let mut exact = 0;
    let (mut most_resets, mut total_resets) = (0, 0);
    let mut times = vec![];
    for seed in first..last {
        let (data, resets) = collect(name, steps, seed, &explorer);
        let start = std::time::Instant::now();
        let found = Identifier::new(&spec).identify(&data);
        times.push(start.elapsed().as_secs_f64());
        let Ok(found) = found else {
            println!("seed {seed}: {:?}", found.err());
            continue;
        };
        let n = spec.state_dim();
        let mut rng = Seed::new(99).stream("box", 0);
        let region = Region::around(
            &spec,
            &Dataset::new(spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim(), spec.dt),
        );
        let truth = system.rates();
        let (mut worst, mut values) = (vec![0.0_f64; n], vec![vec![]; n]);
        for i in 0..10000 {
            let mut x = vec![0.0; n];
            region.sample(&mut rng, &mut x);
            let u: Vec<f64> = spec
                .control
                .iter()
                .enumerate()
                .map(|(k, c)| c.bounds.0 + (c.bounds.1 - c.bounds.0) * ((i * (7919 + 2 * k)) % 1000) as f64 / 999.0)
                .collect();
            let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
            truth.eval(&x, &u, &mut a);
            found.model.eval(&x, &u, &mut b);
            for j in 0..n {
                if spec.state.iter().any(|s| s.kind == sindyna_core::Kind::RateOf(j)) {
                    values[j].push(i as f64);
                    continue;
                }
                values[j].push(a[j]);
                worst[j] = worst[j].max((a[j] - b[j]).abs());
            }
        }
        let spread = |v: &Vec<f64>| {
            let m = v.iter().sum::<f64>() / v.len() as f64;
            (v.iter().map(|x| (x - m).powi(2)).sum::<f64>() / v.len() as f64).sqrt()
        };
        let rel: Vec<f64> = (0..n).map(|j| worst[j] / spread(&values[j])).collect();
        let bad = rel.iter().cloned().fold(0.0, f64::max);
        most_resets = most_resets.max(resets);
        total_resets += resets;
        if bad < 1e-4 {
            exact += 1;
        }
        if bad >= 1e-4 || last - first < 4 {
            println!("seed {seed} resets {resets}: {:?} {}", rel, found.model.to_string().replace('\n', " ; "));
        }
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{name} R={steps} {explorer}: resets {:.1} most {most_resets}; exact {exact} of {}; median {:.2} ms max {:.1}",
        total_resets as f64 / (last - first) as f64,
        last - first,
        1e3 * times[times.len() / 2],
        1e3 * times[times.len() - 1]
    );
}
