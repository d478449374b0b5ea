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

    /// The episodes on a robot that are complete, of their index: on a busy machine some may be cut short and repeated.
    pub(crate) fn complete(mut self) -> Self {
        let complete: Vec<bool> = self
            .column("status")
            .iter()
            .map(|status| *status == "complete")
            .collect();
        let mut complete = complete.into_iter();
        self.rows.retain(|_| complete.next().unwrap());
        self
    }

    pub(crate) fn column(&self, name: &str) -> Vec<&str> {
        let column = self.head.iter().position(|own| own == name).unwrap();
        self.rows.iter().map(|row| &*row[column]).collect()
    }

    pub(crate) fn numbers(&self, name: &str) -> Vec<f32> {
        self.column(name).iter().map(|cell| cell.parse().unwrap()).collect()
    }
}
