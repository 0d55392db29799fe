//! Multilayer perceptrons whose parameters are one flat vector.

use pulp::{Arch, Simd, WithSimd};
use rand::RngExt as _;
use sindyna_core::Rng;

use crate::affine::affine_rows;

/// A fully connected network with ReLU after every layer but the last.
///
/// `sizes` are the widths from the input to the output. The parameters lie layer after layer: weights W row-major
/// (inputs, outputs), then biases b (outputs); y = x W + b for a row x. One vector, so that optimisers, target
/// networks and files are single loops.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mlp {
    sizes: Vec<usize>,
    pub(crate) params: Vec<f32>,
}

/// Where the parameters of one layer lie.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layer {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    offset: usize,
}

impl Layer {
    /// Splits this layer's part of `params` into weights (inputs, outputs) and biases (outputs).
    pub(crate) fn of(self, params: &[f32]) -> (&[f32], &[f32]) {
        params[self.offset..self.offset + self.len()].split_at(self.inputs * self.outputs)
    }

    /// [`Self::of`] for writing.
    pub(crate) fn of_mut(self, params: &mut [f32]) -> (&mut [f32], &mut [f32]) {
        params[self.offset..self.offset + self.len()].split_at_mut(self.inputs * self.outputs)
    }

    fn len(self) -> usize {
        (self.inputs + 1) * self.outputs
    }
}

impl Mlp {
    /// A network of `sizes` with weights and biases uniform in ±1/√inputs of their layer, as PyTorch's `nn.Linear`.
    pub(crate) fn random(sizes: &[usize], rng: &mut Rng) -> Self {
        let mut net = Self::from_params(sizes, vec![0.0; n_params(sizes)]);
        for l in 0..net.depth() {
            let layer = net.layer(l);
            let bound = 1.0 / (layer.inputs as f64).sqrt();
            for p in &mut net.params[layer.offset..layer.offset + layer.len()] {
                *p = rng.random_range(-bound..=bound) as f32;
            }
        }
        net
    }

    /// The network of `sizes` with these parameters, as many as its layers have.
    pub(crate) fn from_params(sizes: &[usize], params: Vec<f32>) -> Self {
        assert!(sizes.len() >= 2, "a network has an input and an output");
        assert_eq!(params.len(), n_params(sizes), "parameters of a network of {sizes:?}");
        Self { sizes: sizes.to_vec(), params }
    }

    /// Number of layers with parameters.
    pub(crate) fn depth(&self) -> usize {
        self.sizes.len() - 1
    }

    /// Width of the input.
    pub(crate) fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Width of the output.
    pub(crate) fn outputs(&self) -> usize {
        self.sizes[self.depth()]
    }

    /// Widths from the input to the output.
    pub(crate) fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Layer `l`, counted from the input.
    pub(crate) fn layer(&self, l: usize) -> Layer {
        let offset = n_params(&self.sizes[..=l]);
        Layer { inputs: self.sizes[l], outputs: self.sizes[l + 1], offset }
    }

    /// The outputs for each row of `inputs` (rows, inputs), into `outputs` (rows, outputs).
    ///
    /// Every sum starts at the bias and runs over the inputs in order, so a row's result depends neither on the rows
    /// beside it nor on the machine: what acts in a controller is what was evaluated.
    pub(crate) fn evaluate_rows(&self, inputs: &[f32], outputs: &mut [f32]) {
        struct Evaluation<'a>(&'a Mlp, &'a [f32], &'a mut [f32]);
        impl WithSimd for Evaluation<'_> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                let Self(net, inputs, outputs) = self;
                // As many rows at once as keep the adders busy while each waits for its own sums.
                const ABREAST: usize = 4;
                let abreast = inputs.len() / net.inputs() / ABREAST * ABREAST;
                let (inputs, last_inputs) = inputs.split_at(abreast * net.inputs());
                let (outputs, last_outputs) = outputs.split_at_mut(abreast * net.outputs());
                net.evaluate_abreast::<S, ABREAST>(simd, inputs, outputs);
                net.evaluate_abreast::<S, 1>(simd, last_inputs, last_outputs);
            }
        }
        Arch::new().dispatch(Evaluation(self, inputs, outputs));
    }

    /// [`Self::evaluate_rows`] for R rows at once, of which there must be a multiple.
    #[inline(always)]
    fn evaluate_abreast<S: Simd, const R: usize>(&self, simd: S, inputs: &[f32], outputs: &mut [f32]) {
        let widest = self.sizes.iter().copied().max().unwrap_or(0);
        let (mut x, mut y) = (vec![0.0; R * widest], vec![0.0; R * widest]);
        let groups = inputs.chunks_exact(R * self.inputs()).zip(outputs.chunks_exact_mut(R * self.outputs()));
        for (inputs, outputs) in groups {
            for (x, input) in x.chunks_exact_mut(widest).zip(inputs.chunks_exact(self.inputs())) {
                x[..input.len()].copy_from_slice(input);
            }
            for l in 0..self.depth() {
                let hidden = l + 1 < self.depth();
                affine_rows::<S, R>(simd, &x, widest, self.layer(l).of(&self.params), hidden, &mut y);
                std::mem::swap(&mut x, &mut y);
            }
            for (x, output) in x.chunks_exact(widest).zip(outputs.chunks_exact_mut(self.outputs())) {
                output.copy_from_slice(&x[..output.len()]);
            }
        }
    }
}

fn n_params(sizes: &[usize]) -> usize {
    sizes.windows(2).map(|w| (w[0] + 1) * w[1]).sum()
}
