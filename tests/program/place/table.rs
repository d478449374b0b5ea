//! A table that the program has written.

use crate::place::Place;

/// A table, by the names of its columns.
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn read(place: &Place, name: &str) -> Self {
        let text = place.text(name);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let cells = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
        Self {
            head: cells(reader.headers().unwrap()),
            rows: reader.records().map(|record| cells(&record.unwrap())).collect(),
        }
    }

    pub(crate) fn column(&self, name: &str) -> Vec<&str> {
        let column = self.head.iter().position(|own| own == name).unwrap();
        self.rows.iter().map(|row| &*row[column]).collect()
    }

    pub(crate) fn numbers(&self, name: &str) -> Vec<f32> {
        self.column(name).iter().map(|cell| cell.parse().unwrap()).collect()
    }
}
