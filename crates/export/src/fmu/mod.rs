//! FMUs: FMI 2.0 for co-simulation, with C sources, and the library for this machine where it has a compiler.
//!
//! Of the 200 tools that the FMI project lists as importing co-simulation (June 2026), 190 name 2.0, 80 name 3.0, none 3.0 without 2.0. Nothing of 3.0
//! would be used: every variable is one real number. Inputs are held over a step, states are outputs, coefficients parameters.

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
