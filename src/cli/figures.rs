//! The figures by which methods are compared: what each is called, what it means, and how it is written.

use super::print;
use super::results::{Errors, Row, SamplingErrors};
use umbrage::truth::CoverageError;

/// What a figure is.
#[derive(Debug, PartialEq)]
pub struct Column {
    /// Above the column.
    pub name: &'static str,
    /// One sentence.
    pub meaning: &'static str,
    decimals: usize,
}

const COST: [Column; 3] = [
    Column {
        name: "ms",
        meaning: "The median time of a frame in milliseconds, from after the depth prepass to the end of the lookup.",
        decimals: 2,
    },
    Column { name: "ratio", meaning: "That time over the time of the first method.", decimals: 2 },
    Column { name: "MiB", meaning: "The device memory that the method holds.", decimals: 1 },
];

const ERRORS: [Column; 4] = [
    Column {
        name: "mismatch %",
        meaning: "The share of decided pixels that differ from ray tracing. A pixel is decided where the surface faces \
                  the light, the light reaches it, and rays from beside it all give the same answer.",
        decimals: 4,
    },
    Column {
        name: "edge_error %",
        meaning: "The same pixels, as a share of the pixels at shadow edges in place of all decided ones.",
        decimals: 2,
    },
    Column {
        name: "off_edge %",
        meaning: "The share of decided pixels that differ and that no edge within 1.5 pixels explains: acne and leaks.",
        decimals: 4,
    },
    Column {
        name: "lost %",
        meaning: "The share of decided pixels that should be in a shadow of which nothing is left within 1.5 pixels.",
        decimals: 4,
    },
];

const COVERAGE: [Column; 2] = [
    Column {
        name: "coverage %",
        meaning: "The mean distance from the share of ray-traced samples of a pixel that the light reaches.",
        decimals: 4,
    },
    Column { name: "on edges %", meaning: "The same over the pixels that are partly lit.", decimals: 2 },
];

const SAMPLING: [Column; 6] = [
    Column {
        name: "undersampled %",
        meaning: "The share of samples with a side of a texel longer than a pixel.",
        decimals: 2,
    },
    Column {
        name: "storage factor",
        meaning: "The texels a pixel of the image that the map would need so that no side of a texel is longer than a pixel, the \
                  tilt of surfaces left out.",
        decimals: 2,
    },
    Column { name: "s median", meaning: "The sides of texels along the map's first axis, in pixels.", decimals: 3 },
    Column { name: "s 95 %", meaning: "What 95 percent of them do not exceed.", decimals: 3 },
    Column { name: "t median", meaning: "The same along its second axis.", decimals: 3 },
    Column { name: "t 95 %", meaning: "What 95 percent of these do not exceed.", decimals: 3 },
];

/// One value of a column.
#[derive(Debug)]
pub struct Figure {
    pub column: &'static Column,
    pub value: f64,
}

impl Figure {
    /// The value as tables show it.
    pub fn text(&self) -> String {
        format!("{:.*}", self.column.decimals, self.value)
    }
}

/// The figures of a row, in the order of the table; of all rows of a comparison the same columns.
pub fn of_row(row: &Row) -> Vec<Figure> {
    let mut figures = figures(&COST, [row.ms.median, row.ratio, print::mib(row.bytes)]);
    figures.extend(of_errors(&row.errors.all));
    if let Some(CoverageError { mean, edge, .. }) = row.coverage {
        figures.extend(self::figures(&COVERAGE, [mean, edge]));
    }
    figures
}

/// The errors alone: those of one light.
pub fn of_errors(e: &Errors) -> Vec<Figure> {
    figures(&ERRORS, [e.mismatch, e.edge_error, e.off_edge, e.lost])
}

/// How large texels look to one light.
pub fn of_sampling(e: &SamplingErrors) -> Vec<Figure> {
    figures(&SAMPLING, [e.undersampled, e.storage_factor, e.s.median, e.s.p95, e.t.median, e.t.p95])
}

fn figures<const N: usize>(columns: &'static [Column; N], values: [f64; N]) -> Vec<Figure> {
    columns.iter().zip(values).map(|(column, value)| Figure { column, value }).collect()
}
