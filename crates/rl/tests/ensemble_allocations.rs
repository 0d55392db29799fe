//! A steady epoch of an ensemble's training takes nothing from the heap but its line of the report.

#![expect(unsafe_code, reason = "an allocator that counts has to be one")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use ndarray::Array2;
use sindyna_core::Seed;
use sindyna_rl::{Activation, EnsembleConfig, EnsembleTrainer};

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

fn allocations(activation: Activation, epochs: usize) -> usize {
    let config = EnsembleConfig {
        members: 2,
        elites: 1,
        hidden: vec![20, 30],
        weight_decay: vec![0.0; 3],
        activation,
        patience: epochs,
        max_epochs: Some(epochs),
        ..EnsembleConfig::janner()
    };
    let trainer = EnsembleTrainer::new(config).expect("usable settings");
    let rows = Array2::from_shape_fn((700, 3), |(i, j)| (1.7 * (i * 3 + j) as f64).sin());
    let before = COUNT.get();
    trainer.fit(rows.view(), rows.view(), None, &mut Seed::new(0).numpy()).expect("enough rows");
    COUNT.get() - before
}

#[test]
fn no_epoch_but_the_first_allocates() {
    for activation in [Activation::Relu, Activation::Swish] {
        let more = allocations(activation, 12) - allocations(activation, 2);
        assert_eq!(more, 10, "allocations in ten epochs more with {activation:?}: one entry of the report each");
    }
}
