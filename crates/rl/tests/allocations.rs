//! A steady update takes nothing from the heap.

#![expect(unsafe_code, reason = "an allocator that counts has to be one")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use sindyna_core::{Agent, Batch, Seed};
use sindyna_rl::{Isa, Sac, SacConfig, SacDiscrete, Scaling};

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // While a thread ends there is no counter left, and nothing to count.
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: the system's allocator does the work.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn batch() -> Batch {
    let mut batch = Batch::zeros(256, 3, 1);
    batch.observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
    batch.next_observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64 + 0.1).sin());
    batch.rewards.iter_mut().enumerate().for_each(|(i, v)| *v = (7.0 * i as f64).cos());
    batch
}

fn check(mut agent: impl Agent, isa: Isa) {
    let (batch, mut rng) = (batch(), Seed::new(0).stream("allocations", 0));
    agent.update(&batch, &mut rng).expect("finite losses");
    let before = COUNT.get();
    for _ in 0..50 {
        agent.update(&batch, &mut rng).expect("finite losses");
    }
    assert_eq!(COUNT.get() - before, 0, "allocations in 50 updates with {isa}");
}

#[test]
fn no_update_but_the_first_allocates() {
    for isa in Isa::ALL {
        for hidden in [vec![64, 64], vec![96, 33]] {
            let (config, mut rng) = (SacConfig { hidden, ..SacConfig::default() }, Seed::new(1).numpy());
            let sac = Sac::new(config.clone(), Scaling::identity(3), &[-2.0], &[2.0], &mut rng).expect("usable");
            let numbered = SacDiscrete::new(config, Scaling::identity(3), 2, &mut rng).expect("usable");
            // Machines without the instructions have nothing to check.
            sac.with_isa(isa).into_iter().for_each(|agent| check(agent, isa));
            numbered.with_isa(isa).into_iter().for_each(|agent| check(agent, isa));
        }
    }
}
