//! The tables that pages are drawn from.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use ndarray::{Array2, array};
use sindyna_record::TableError;
use sindyna_record::identification::PredictionTable;
use sindyna_record::run::{EpisodeRow, EpisodeTable, Moment};
use sindyna_sindy::{Entry, Form, Model, ModelParts, Recording};

/// x⁺ = 0.5 x + u.
fn model() -> Model {
    Model::new(ModelParts {
        states: vec!["x".into()],
        controls: vec!["u".into()],
        form: Form::Discrete,
        dt: 0.1,
        readings: None,
        terms: vec!["x".into(), "u".into()],
        equations: vec![vec![Entry::new(0, 0.5), Entry::new(1, 1.0)]],
        kinematic: vec![false],
        offsets: vec![0.0],
        n_features: 2,
    })
    .unwrap()
}

fn table(recordings: &[Recording]) -> PredictionTable {
    PredictionTable::of(&model(), recordings, vec!["x, \"y\" [m]".into()], vec!["u".into()])
}

#[test]
fn predictions_are_those_of_the_model_and_read_back() {
    let recording = Recording::even(0.1, array![[1.0], [2.0], [4.0]], Some(array![[1.0], [0.0]]));
    let table = table(&[recording]);
    let column = |of: fn(&sindyna_record::identification::PredictionRow) -> &Vec<f64>| -> Vec<Vec<f64>> {
        table.rows.iter().map(|row| of(row).clone()).collect()
    };
    assert_eq!(column(|r| &r.one_step), [vec![], vec![1.5], vec![1.0]], "half of the sample before, and the input");
    assert_eq!(column(|r| &r.free_run), [vec![1.0], vec![1.5], vec![0.75]], "from the first sample alone");
    assert_eq!(column(|r| &r.inputs), [vec![1.0], vec![0.0], vec![]]);
    let text = String::from_utf8(table.to_csv().unwrap()).unwrap();
    assert_eq!(PredictionTable::from_csv(&text, 1).unwrap(), table);
    assert!(matches!(PredictionTable::from_csv(&text, 9), Err(TableError::Columns { .. })));
    let broken = text.replace("0.75", "<b>");
    assert!(PredictionTable::from_csv(&broken, 1).unwrap_err().to_string().contains("row 3: `<b>` is not a number"));
}

#[test]
fn of_long_recordings_the_beginning_is_whole_and_the_rest_is_spread() {
    let long = || Recording::even(0.1, Array2::zeros((50_000, 1)), Some(Array2::zeros((49_999, 1))));
    let table = table(&[long(), long()]);
    assert_eq!(table.window(), 600);
    assert!((1_400..=1_500).contains(&table.rows.len()), "{}", table.rows.len());
    assert!(table.rows.iter().any(|row| row.trajectory == 1), "the second recording is in it");
    assert!(table.rows.iter().all(|row| row.sample == 0 || row.one_step == [0.0]));
}

#[test]
fn an_episode_reads_back() {
    let first = EpisodeRow {
        t: 0.0,
        states: vec![1.0],
        inputs: vec![0.5],
        model_states: vec![1.0],
        model_inputs: vec![0.25],
        reward: Some(-1.0),
    };
    let last = EpisodeRow { t: 0.1, states: vec![2.0], ..EpisodeRow::default() };
    let table = EpisodeTable { states: vec!["x".into()], inputs: vec!["u".into()], rows: vec![first, last] };
    let text = String::from_utf8(table.to_csv().unwrap()).unwrap();
    assert!(text.starts_with("step,t,x,u,x (model),u (model),reward\n0,0,1,0.5,1,0.25,-1\n"), "{text}");
    assert_eq!(EpisodeTable::from_csv(&text, 1).unwrap(), table);
    assert!(EpisodeTable::from_csv("step,t,x,u,v,reward\n", 1).is_err());
}

#[test]
fn moments_are_those_of_the_training_curve() {
    let text = "{\"event\":\"fitted\",\"rows\":3}\n{\"event\":\"updated\",\"updates\":5}\nno JSON\n\
                {\"event\":\"trial\",\"updates\":7,\"model_return\":-2.5}\n{\"event\":\"trial\",\"model_return\":null}\n\
                {\"event\":\"confirmed\",\"real_return\":1.0}\n";
    assert_eq!(
        Moment::all(text),
        [
            Moment::Fitted { updates: 0 },
            Moment::Trial { updates: 7, model_return: -2.5 },
            Moment::Confirmed { updates: 7, real_return: 1.0 },
        ]
    );
}
