//! Conversion of a sweep's tables to Parquet, for readers that need it faster or smaller than text.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use csv::StringRecord;
use oneiro_base::contents::{self, Holds};
use oneiro_base::disk::write_through;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

/// Rows of a row group. Only one group is in memory at a time, whatever the table's length.
const ROWS: usize = 1 << 17;

/// Writes a CSV file's table as Parquet, with the same bytes for the same table on every machine. `columns` are the
/// names and types of the file's columns, in order; an empty cell becomes a null. The file is written completely or not
/// at all, and replaces an earlier one. It is on disk afterwards; its name is, once its directory has been synced.
///
/// # Errors
/// Exit 5 with the line and the column if the CSV file is missing or has a cell of the wrong type; exit 6 if reading or
/// writing fails.
pub(crate) fn convert(csv: &Path, parquet: &Path, columns: &[contents::Column]) -> Result {
    let mut table = Table::open(csv, columns)?;
    let unwritten = |error| Failure::storage(parquet, &system(error));
    write_through(parquet, |file| {
        let schema = schema(columns).map_err(unwritten)?;
        let properties = Arc::new(properties(columns));
        let mut writer = SerializedFileWriter::new(file, schema, properties).map_err(unwritten)?;
        while table.read()? > 0 {
            table.write(&mut writer).map_err(unwritten)?;
        }
        writer.finish().map_err(unwritten)?;
        Ok(())
    })
}

/// Extracts the system's error from that of the Parquet library, for its kind.
fn system(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => error.downcast().map_or_else(io::Error::other, |error| *error),
        error => io::Error::other(error),
    }
}

fn schema(columns: &[contents::Column]) -> Written<Arc<Type>> {
    let column = |contents::Column { name, holds, .. }: &contents::Column| {
        let (physical, logical) = match holds {
            Holds::Whole => (Physical::INT64, None),
            Holds::Number => (Physical::DOUBLE, None),
            Holds::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        Type::primitive_type_builder(name, physical)
            .with_logical_type(logical)
            .with_repetition(Repetition::OPTIONAL)
            .build()
            .map(Arc::new)
    };
    let fields = columns.iter().map(column).collect::<Written<_>>()?;
    Type::group_type_builder("table")
        .with_fields(fields)
        .build()
        .map(Arc::new)
}

/// Runs and generations count up, so their differences are tiny. Numbers of similar size share bytes, which the
/// compression sees if bytes are grouped by position. A dictionary would only enlarge columns of mostly distinct
/// values, such as scores.
fn properties(columns: &[contents::Column]) -> WriterProperties {
    let properties = WriterProperties::builder()
        .set_created_by(concat!("oneiro version ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false);
    let encoded = columns
        .iter()
        .fold(properties, |properties, contents::Column { name, holds, .. }| {
            let encoding = match holds {
                Holds::Whole => Encoding::DELTA_BINARY_PACKED,
                Holds::Number => Encoding::BYTE_STREAM_SPLIT,
                Holds::Text => Encoding::PLAIN,
            };
            properties.set_column_encoding(ColumnPath::from(name.to_string()), encoding)
        });
    encoded.build()
}

/// A table that is read one row group at a time.
struct Table<'a> {
    path: &'a Path,
    reader: csv::Reader<File>,
    /// The row read last.
    row: StringRecord,
    columns: Vec<Column<'a>>,
}

impl<'a> Table<'a> {
    fn open(path: &'a Path, columns: &'a [contents::Column]) -> Result<Self> {
        let file = plain::open_table(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Failure::corrupt(format_args!("{}: is missing", path.display())),
            _ => Failure::storage(path, &error),
        })?;
        let mut table = Self {
            path,
            // Names and row lengths are checked here, with the same messages as in all other checks.
            reader: csv::ReaderBuilder::new()
                .has_headers(false)
                .flexible(true)
                .buffer_capacity(1 << 18)
                .from_reader(file),
            row: StringRecord::new(),
            columns: columns.iter().map(Column::new).collect(),
        };
        table.next()?;
        let names: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
        if table.row == names {
            Ok(table)
        } else {
            Err(table.wrong(format_args!("has other columns; allowed: {}", names.join(","))))
        }
    }

    /// Reads the next row group into the columns and returns its number of rows.
    fn read(&mut self) -> Result<usize> {
        for rows in 0..ROWS {
            if !self.next()? {
                return Ok(rows);
            }
            if self.row.len() != self.columns.len() {
                let (cells, columns) = (self.row.len(), self.columns.len());
                return Err(self.wrong(format_args!("has {cells} cells; allowed: {columns}")));
            }
            for (column, cell) in self.columns.iter_mut().zip(&self.row) {
                if let Err(allowed) = column.push(cell) {
                    let name = column.name;
                    return Err(self.wrong(format_args!("{name} is {cell:?}; allowed: {allowed}, or nothing")));
                }
            }
        }
        Ok(ROWS)
    }

    /// Reads a row; false at the end.
    fn next(&mut self) -> Result<bool> {
        self.reader.read_record(&mut self.row).map_err(|error| {
            let line = error.position().map_or(1, csv::Position::line);
            match error.into_kind() {
                csv::ErrorKind::Io(error) => Failure::storage(self.path, &error),
                _ => self.wrong_at(line, "is no longer text; allowed: UTF-8"),
            }
        })
    }

    /// The error for the row read last.
    fn wrong(&self, problem: impl Display) -> Failure {
        self.wrong_at(self.row.position().map_or(1, csv::Position::line), problem)
    }

    fn wrong_at(&self, line: u64, problem: impl Display) -> Failure {
        Failure::corrupt(format_args!("{}: line {line}: {problem}", self.path.display()))
    }

    /// Moves the row group into a file.
    fn write(&mut self, file: &mut SerializedFileWriter<impl Write + Send>) -> Written<()> {
        let mut group = file.next_row_group()?;
        for column in &mut self.columns {
            // The schema has the same number of columns.
            if let Some(mut writer) = group.next_column()? {
                column.write(&mut writer)?;
                writer.close()?;
            }
        }
        group.close().map(|_| ())
    }
}

/// A column of a row group.
struct Column<'a> {
    name: &'a str,
    /// Whether each row's cell is filled: Parquet's definition levels.
    holds: Vec<i16>,
    /// Values of the filled cells.
    cells: Cells,
}

enum Cells {
    Whole(Vec<i64>),
    Number(Vec<f64>),
    Text(Vec<ByteArray>),
}

impl<'a> Column<'a> {
    fn new(contents::Column { name, holds, .. }: &'a contents::Column) -> Self {
        Self {
            name,
            holds: Vec::new(),
            cells: match holds {
                Holds::Whole => Cells::Whole(Vec::new()),
                Holds::Number => Cells::Number(Vec::new()),
                Holds::Text => Cells::Text(Vec::new()),
            },
        }
    }

    /// Adds a cell, or returns what is allowed.
    fn push(&mut self, cell: &str) -> std::result::Result<(), &'static str> {
        self.holds.push(i16::from(!cell.is_empty()));
        if cell.is_empty() {
            return Ok(());
        }
        match &mut self.cells {
            Cells::Whole(cells) => cells.push(cell.parse().map_err(|_| "a whole number from -2^63 to 2^63 - 1")?),
            Cells::Number(cells) => cells.push(cell.parse().map_err(|_| "a number, NaN among them")?),
            Cells::Text(cells) => cells.push(cell.into()),
        }
        Ok(())
    }

    /// Moves all cells into a file.
    fn write(&mut self, writer: &mut SerializedColumnWriter) -> Written<()> {
        fn write<T: DataType>(
            cells: &mut Vec<T::T>,
            holds: &[i16],
            writer: &mut SerializedColumnWriter,
        ) -> Written<()> {
            writer.typed::<T>().write_batch(cells, Some(holds), None)?;
            cells.clear();
            Ok(())
        }
        match &mut self.cells {
            Cells::Whole(cells) => write::<Int64Type>(cells, &self.holds, writer)?,
            Cells::Number(cells) => write::<DoubleType>(cells, &self.holds, writer)?,
            Cells::Text(cells) => write::<ByteArrayType>(cells, &self.holds, writer)?,
        }
        self.holds.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use parquet::file::metadata::RowGroupMetaData;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    /// A temporary directory, removed when the test ends.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("oneiro-parquet-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        /// Converts a table with these columns.
        fn convert(
            &self,
            text: impl AsRef<[u8]>,
            columns: &[(&'static str, Holds)],
        ) -> Result<SerializedFileReader<File>> {
            let csv = self.0.join("table.csv");
            fs::write(&csv, text).unwrap();
            let columns = columns
                .iter()
                .map(|&(name, holds)| contents::Column::new(name, "", "", holds));
            let columns: Vec<_> = columns.collect();
            convert(&csv, &self.table(), &columns)?;
            Ok(SerializedFileReader::new(File::open(self.table()).unwrap()).unwrap())
        }

        fn table(&self) -> PathBuf {
            self.0.join("table.parquet")
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            // A leftover in the system's temporary directory does no harm.
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    /// Cells of a table, by row.
    fn rows(table: &SerializedFileReader<File>) -> Vec<Vec<Field>> {
        let rows = table.get_row_iter(None).unwrap();
        rows.map(|row| row.unwrap().get_column_iter().map(|(_, cell)| cell.clone()).collect())
            .collect()
    }

    const COLUMNS: [(&str, Holds); 3] = [
        ("seed", Holds::Whole),
        ("evolution.mutation.rate", Holds::Number),
        ("noise.sensor", Holds::Text),
    ];

    const HEAD: &str = "seed,evolution.mutation.rate,noise.sensor\n";

    #[test]
    fn a_table_reads_as_it_was_written() {
        let scratch = Scratch::new("table");
        let text = "9223372036854775807,0.1,\"[0.0, 0.4]\"\n\
                    -9223372036854775808,1e-320,\"\"\"so\"\", \u{3b4}\"\n\
                    0,-0,0\n";
        let table = scratch.convert(HEAD.to_owned() + text, &COLUMNS).unwrap();
        let schema = table.metadata().file_metadata().schema_descr();
        let names = schema.columns().iter().map(|column| column.name());
        assert!(names.eq(COLUMNS.map(|(name, _)| name)));
        let row =
            |whole, number, text: &str| vec![Field::Long(whole), Field::Double(number), Field::Str(text.to_owned())];
        let expected = [
            row(i64::MAX, 0.1, "[0.0, 0.4]"),
            row(i64::MIN, 1e-320, "\"so\", \u{3b4}"),
            row(0, -0.0, "0"),
        ];
        assert_eq!(rows(&table), expected);
        assert!(matches!(rows(&table)[2][1], Field::Double(zero) if zero.is_sign_negative()));
    }

    #[test]
    fn empty_cells_are_nulls_and_nan_is_a_number() {
        let scratch = Scratch::new("nulls");
        let text = HEAD.to_owned() + ",,\n1,NaN,a\n,inf,\n2,,b\n";
        let rows = rows(&scratch.convert(text, &COLUMNS).unwrap());
        assert_eq!(rows[0], [Field::Null, Field::Null, Field::Null]);
        assert!(matches!(rows[1][1], Field::Double(number) if number.is_nan()));
        assert_eq!(rows[2], [Field::Null, Field::Double(f64::INFINITY), Field::Null]);
        assert_eq!(rows[3], [Field::Long(2), Field::Null, Field::Str("b".to_owned())]);
    }

    #[test]
    fn a_table_may_have_no_rows() {
        let scratch = Scratch::new("none");
        let table = scratch.convert(HEAD, &COLUMNS).unwrap();
        assert_eq!(rows(&table), [[]; 0]);
    }

    #[test]
    fn row_groups_have_one_length_but_for_the_last() {
        let scratch = Scratch::new("groups");
        let groups = |rows: usize| -> Vec<i64> {
            let lines = (0..rows).map(|row| format!("{row},{}.5\n", rows - row));
            let text: String = std::iter::once("run,mean\n".to_owned()).chain(lines).collect();
            let table = scratch
                .convert(text, &[("run", Holds::Whole), ("mean", Holds::Number)])
                .unwrap();
            for (row, read) in table.get_row_iter(None).unwrap().enumerate() {
                let cells = read.unwrap().into_columns();
                assert_eq!(cells[0].1, Field::Long(row as i64));
                assert_eq!(cells[1].1, Field::Double((rows - row) as f64 + 0.5));
            }
            let groups = table.metadata().row_groups();
            groups.iter().map(RowGroupMetaData::num_rows).collect()
        };
        let rows = ROWS as i64;
        assert_eq!(groups(2 * ROWS + 3), [rows, rows, 3]);
        assert_eq!(groups(ROWS), [rows]);
    }

    #[test]
    fn the_same_table_has_the_same_bytes() {
        let scratch = Scratch::new("bytes");
        let lines = (0..5000).map(|row| format!("{},{}.25,run {}\n", row * row, row % 7, row % 11));
        let text: String = std::iter::once(HEAD.to_owned()).chain(lines).collect();
        let bytes = || {
            scratch.convert(&text, &COLUMNS).unwrap();
            fs::read(scratch.table()).unwrap()
        };
        let first = bytes();
        assert_eq!(first, bytes());
        // The same on every machine. Another version of the program or of the library may have others.
        assert_eq!(
            blake3::hash(&first).to_hex().as_str(),
            "b582b08cf49df697dbd536a962043d4c4b54b050e6351ff1278a67889b1b9105"
        );
    }

    #[test]
    fn invalid_tables_are_refused() {
        let scratch = Scratch::new("refused");
        scratch.convert(format!("{HEAD}1,2,3\n"), &COLUMNS).unwrap();
        let before = fs::read(scratch.table()).unwrap();
        let columns = "line 1: has other columns; allowed: seed,evolution.mutation.rate,noise.sensor";
        let whole = "allowed: a whole number from -2^63 to 2^63 - 1, or nothing";
        let number = "allowed: a number, NaN among them, or nothing";
        let good = format!("{HEAD}1,0.5,a\n");
        let cases: [(&str, &[u8], String); 8] = [
            ("", b"", columns.to_owned()),
            ("", b"seed,best\n", columns.to_owned()),
            (&good, b"1.5,2,b\n", format!("line 3: seed is \"1.5\"; {whole}")),
            (
                &good,
                b"9223372036854775808,,\n",
                format!("line 3: seed is \"9223372036854775808\"; {whole}"),
            ),
            (
                &good,
                b"1,,\"b\nc\"\n1,1/2,b\n",
                format!("line 5: evolution.mutation.rate is \"1/2\"; {number}"),
            ),
            (&good, b"1,2,b\n3,4\n", "line 4: has 2 cells; allowed: 3".to_owned()),
            (&good, b"1,2,b,c\n", "line 3: has 4 cells; allowed: 3".to_owned()),
            (
                &good,
                b"1,2,\xff\n",
                "line 3: is no longer text; allowed: UTF-8".to_owned(),
            ),
        ];
        for (start, end, problem) in cases {
            let failure = scratch
                .convert([start.as_bytes(), end].concat(), &COLUMNS)
                .err()
                .unwrap();
            assert_eq!(failure.code(), 5);
            assert_eq!(
                failure.to_string(),
                format!("{}: {problem}", scratch.0.join("table.csv").display())
            );
            // The earlier file is intact, and nothing is left of the new one.
            assert_eq!(fs::read(scratch.table()).unwrap(), before);
            assert_eq!(fs::read_dir(&scratch.0).unwrap().count(), 2);
        }
    }

    #[test]
    fn disk_errors_are_reported() {
        let scratch = Scratch::new("disk");
        let columns = [contents::Column::whole("run", "", "")];
        let refused = |csv: &Path, parquet: &Path| convert(csv, parquet, &columns).unwrap_err();
        let missing = refused(&scratch.0.join("no.csv"), &scratch.table());
        assert_eq!(missing.code(), 5);
        assert!(missing.to_string().ends_with("no.csv: is missing"));
        let csv = scratch.0.join("table.csv");
        fs::write(&csv, "run\n1\n").unwrap();
        assert_eq!(refused(&csv, &scratch.0.join("no/table.parquet")).code(), 6);
        let directory = refused(&scratch.0, &scratch.table());
        assert_eq!(directory.code(), 3);
        assert!(directory.to_string().ends_with("is a directory; allowed: a file"));
        let full = system(io::Error::from(io::ErrorKind::StorageFull).into());
        assert_eq!(full.kind(), io::ErrorKind::StorageFull);
    }
}
