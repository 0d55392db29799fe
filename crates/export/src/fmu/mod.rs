//! FMUs: FMI 2.0 for co-simulation, which more tools read than 3.0; with C sources, and the library for this machine where it has a compiler.
//!
//! Nothing of FMI 3.0 would be used: every variable is one real number. Inputs are held over a step, states are outputs, coefficients parameters.

mod compile;
mod description;
mod source;

use std::io::{Cursor, Write as _};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::program::Program;

/// What the library is called.
const IDENTIFIER: &str = "sindyna_model";

/// An FMU, and what is to be said of it.
pub(super) fn write(program: &Program) -> Result<(Vec<u8>, String), zip::result::ZipError> {
    let variables = description::variables(program);
    let start: Vec<f64> = variables.iter().map(|v| v.start).collect();
    // Of the same program, the same bytes; of another, another name.
    let guid = format!("sindyna-{:08x}", crc32fast::hash(source::write(program, "", &start).as_bytes()));
    let code = source::write(program, &guid, &start);
    let xml = description::write(program, IDENTIFIER, &guid, &variables);
    let library = compile::compiled(&code, IDENTIFIER);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut add = |name: &str, bytes: &[u8]| {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
        Ok::<(), zip::result::ZipError>(())
    };
    add("modelDescription.xml", xml.as_bytes())?;
    add("sources/model.c", code.as_bytes())?;
    let note = match &library {
        Ok(library) => {
            add(&library.path, &library.bytes)?;
            format!("with sources, and {}", library.path)
        }
        Err(why) => format!("with sources alone: {why}"),
    };
    Ok((archive.finish()?.into_inner(), note))
}
