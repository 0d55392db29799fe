//! Graphs of operators, built one value after the other.

use std::collections::HashMap;

use prost::Message as _;

use super::proto::{
    Attribute, Dimension, Graph, Kind, Model, Node, OperatorSet, Shape, Tensor, TensorKind, ValueInfo, data_type,
};
use crate::program::PRODUCER;

/// Version of the format, and of the operators: those of ONNX 1.12, which every tool of the last years reads.
const IR_VERSION: i64 = 8;
const OPERATORS: i64 = 17;

/// A graph that grows. Values are known by their names.
#[derive(Default)]
pub(super) struct Builder {
    graph: Graph,
    values: usize,
    /// Operators and what they are given, with what they give: nothing is computed twice.
    known: HashMap<(String, Vec<String>, Option<i64>), String>,
    constants: HashMap<u64, String>,
}

impl Builder {
    fn name(&mut self) -> String {
        self.values += 1;
        format!("v{}", self.values)
    }

    /// What the operator called `kind` gives for `inputs`.
    pub(super) fn op(&mut self, kind: &str, inputs: &[&str]) -> String {
        self.op_with(kind, inputs, None)
    }

    /// The same with an attribute.
    pub(super) fn op_with(&mut self, kind: &str, inputs: &[&str], attribute: Option<(&str, i64)>) -> String {
        let inputs: Vec<String> = inputs.iter().map(|name| (*name).to_owned()).collect();
        let key = (kind.to_owned(), inputs, attribute.map(|(_, value)| value));
        if let Some(name) = self.known.get(&key) {
            return name.clone();
        }
        let name = self.name();
        self.node(kind, &key.1, attribute, &name);
        self.known.insert(key, name.clone());
        name
    }

    fn node(&mut self, kind: &str, inputs: &[String], attribute: Option<(&str, i64)>, output: &str) {
        let attribute =
            attribute.map(|(name, i)| Attribute { name: name.to_owned(), i: Some(i), kind: Attribute::INT });
        self.graph.node.push(Node {
            input: inputs.to_vec(),
            output: vec![output.to_owned()],
            op_type: kind.to_owned(),
            attribute: attribute.into_iter().collect(),
        });
    }

    /// A number, of the shape (1, 1).
    pub(super) fn number(&mut self, value: f64) -> String {
        if let Some(name) = self.constants.get(&value.to_bits()) {
            return name.clone();
        }
        let name = self.tensor(&[1, 1], data_type::DOUBLE, value.to_le_bytes().to_vec());
        self.constants.insert(value.to_bits(), name.clone());
        name
    }

    /// A row of numbers, of the shape (1, m).
    pub(super) fn row(&mut self, values: &[f64]) -> String {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensor(&[1, values.len()], data_type::DOUBLE, bytes)
    }

    /// Numbers as another type.
    pub(super) fn cast(&mut self, name: &str, to: i32) -> String {
        self.op_with("Cast", &[name], Some(("to", i64::from(to))))
    }

    /// Numbers of single precision, as double precision.
    pub(super) fn floats(&mut self, shape: &[usize], values: &[f32]) -> String {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let name = self.tensor(shape, data_type::FLOAT, bytes);
        self.cast(&name, data_type::DOUBLE)
    }

    fn tensor(&mut self, shape: &[usize], data_type: i32, raw_data: Vec<u8>) -> String {
        let name = self.name();
        let dims = shape.iter().map(|size| *size as i64).collect();
        self.graph.initializer.push(Tensor { dims, data_type, name: name.clone(), raw_data });
        name
    }

    /// The columns, (batch, 1) each, of an input of the shape (batch, width).
    pub(super) fn columns(&mut self, name: &str, width: usize) -> Vec<String> {
        self.input(name, width);
        let column = |i: usize| {
            let index = self.tensor(&[1], data_type::INT64, (i as i64).to_le_bytes().to_vec());
            self.op_with("Gather", &[name, &index], Some(("axis", 1)))
        };
        (0..width).map(column).collect()
    }

    /// An input of the shape (batch, width).
    pub(super) fn input(&mut self, name: &str, width: usize) {
        self.graph.input.push(value(name, data_type::DOUBLE, width));
    }

    /// An output of the shape (batch, width): what the operator gives for `inputs`.
    pub(super) fn output(
        &mut self,
        name: &str,
        width: usize,
        kind: &str,
        inputs: &[&str],
        attribute: Option<(&str, i64)>,
    ) {
        let inputs: Vec<String> = inputs.iter().map(|name| (*name).to_owned()).collect();
        self.node(kind, &inputs, attribute, name);
        let element = if kind == "ArgMax" { data_type::INT64 } else { data_type::DOUBLE };
        self.graph.output.push(value(name, element, width));
    }

    /// The file.
    pub(super) fn file(self, name: &str, text: &[String]) -> Vec<u8> {
        let graph = Graph { name: name.to_owned(), doc_string: text.join("\n"), ..self.graph };
        let model = Model {
            ir_version: IR_VERSION,
            producer_name: PRODUCER.to_owned(),
            producer_version: env!("CARGO_PKG_VERSION").to_owned(),
            graph: Some(graph),
            opset_import: vec![OperatorSet { version: OPERATORS }],
        };
        model.encode_to_vec()
    }
}

/// A matrix of so many columns, one row for each element of a batch.
fn value(name: &str, data_type: i32, width: usize) -> ValueInfo {
    let batch = Dimension { value: None, name: Some("batch".to_owned()) };
    let width = Dimension { value: Some(width as i64), name: None };
    let tensor = TensorKind { data_type, shape: Some(Shape { dim: vec![batch, width] }) };
    ValueInfo { name: name.to_owned(), kind: Some(Kind { tensor: Some(tensor) }) }
}
