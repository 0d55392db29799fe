//! Files of policies that are far too large to be any.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::HashMap;
use std::time::{Duration, Instant};

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use sindyna_core::Seed;
use sindyna_rl::{PolicyFileError, Sac, SacConfig, SavedPolicy, Scaling};

#[test]
fn a_file_of_two_hundred_thousand_tensors_is_refused_in_seconds() {
    let scaling = Scaling { center: vec![0.0], scale: vec![1.0] };
    let sac = Sac::new(SacConfig::default(), scaling, &[-1.0], &[1.0], &mut Seed::new(0).numpy()).unwrap();
    let policy = SavedPolicy::from(sac.frozen()).to_safetensors();
    let (_, metadata) = SafeTensors::read_metadata(&policy).unwrap();
    let format: HashMap<String, String> = metadata.metadata().clone().unwrap();
    let names = (0..100_000).flat_map(|l| [format!("layers.{l}.weight"), format!("layers.{l}.bias")]);
    let empty = |name| (name, TensorView::new(Dtype::F32, vec![0], &[]).unwrap());
    let file = safetensors::serialize(names.map(empty), Some(format)).unwrap();
    let begun = Instant::now();
    let refusal = SavedPolicy::from_safetensors(&file).unwrap_err();
    assert!(matches!(refusal, PolicyFileError::Unexpected { .. }), "{refusal}");
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
}
