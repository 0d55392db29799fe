//! How often the equations found are the true ones.
use sindyna_core::{Dataset, Dynamics, Environment, Explorer, Seed, Region};
use sindyna_dyna::{Alternating, Uniform};
use sindyna_sindy::Identifier;

fn collect(name: &str, steps: usize, seed: u64, explorer: &str) -> (Dataset, usize) {
    let system = sindyna_envs::find(name).unwrap();
    let spec = system.spec().clone();
    let mut env = system.environment();
    let mut rng = Seed::new(seed).stream("real system", 0);
    let mut explorer: Box<dyn Explorer> = match explorer {
        "alternating" => Box::new(Alternating::new(&spec, 0.2)),
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
    }
    let resets = data.n_rollouts();
    (data, resets)
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (name, steps, first, last, explorer) = (&args[1], args[2].parse::<usize>().unwrap(), args[3].parse::<u64>().unwrap(), args[4].parse::<u64>().unwrap(), args[5].clone());
    let system = sindyna_envs::find(name).unwrap();
    let spec = system.spec().clone();
    let mut exact = 0;
    let mut times = vec![];
    for seed in first..last {
        let (data, resets) = collect(name, steps, seed, &explorer);
        let start = std::time::Instant::now();
        let found = Identifier::new(&spec).identify(&data);
        times.push(start.elapsed().as_secs_f64());
        let Ok(found) = found else { println!("seed {seed}: {:?}", found.err()); continue };
        // worst error over the box
        let region = Region::around(&spec, &Dataset::new(spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim(), spec.dt));
        let mut rng = Seed::new(99).stream("box", 0);
        let n = spec.state_dim();
        let truth = system.dynamics();
        let (mut worst, mut values) = (vec![0.0_f64; n], vec![vec![]; n]);
        for i in 0..2000 {
            let mut x = vec![0.0; n];
            region.sample(&mut rng, &mut x);
            let u: Vec<f64> = spec.control.iter().map(|c| c.bounds.0 + (c.bounds.1 - c.bounds.0) * ((i * 7919) % 1000) as f64 / 999.0).collect();
            let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
            if truth.step(&x, &u, &mut rng, &mut a).is_err() { continue; }
            if a.iter().zip(&spec.state).any(|(v, c)| *v <= c.bounds.0 || *v >= c.bounds.1) || a.iter().zip(&x).zip(&spec.state).any(|((_, _), _)| false) { continue; }
            if name == "inverted-pendulum" && (x[0].abs() > 0.8 || a[0].abs() > 0.8) { continue; }
            found.model.step(&x, &u, &mut rng, &mut b).ok();
            for j in 0..n {
                values[j].push((a[j] - x[j]) / spec.dt);
                worst[j] = worst[j].max(((a[j] - b[j]) / spec.dt).abs());
            }
        }
        let spread = |v: &Vec<f64>| { let m = v.iter().sum::<f64>() / v.len() as f64; (v.iter().map(|x| (x - m).powi(2)).sum::<f64>() / v.len() as f64).sqrt() };
        let rel: Vec<f64> = (0..n).map(|j| worst[j] / spread(&values[j])).collect();
        let bad = rel.iter().cloned().fold(0.0, f64::max);
        if bad < 1e-4 { exact += 1; }
        if bad >= 1e-4 || last - first < 4 {
            println!("seed {seed} resets {resets}: {:?} {}", rel, found.model.to_string().replace('\n', " ; "));
        }
    }
    times.sort_by(f64::total_cmp);
    println!("{name} R={steps} {explorer}: exact {exact} of {}; median {:.2} ms max {:.1}", last - first, 1e3 * times[times.len() / 2], 1e3 * times[times.len() - 1]);
}
