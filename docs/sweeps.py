# %% [markdown]
# What came of a sweep, with pandas and with Polars: `python3 docs/sweeps.py SWEEP`, or cell by cell as a notebook.
# It needs `pip install pandas polars pyarrow`.

# %%
import sys
from pathlib import Path

import pandas as pd
import polars as pl
from polars.testing import assert_frame_equal

sweep = Path(sys.argv[1] if sys.argv[1:] and "ipykernel" not in sys.modules else "sweep")


def read(name, columns=None):
    csv, parquet = sweep / f"{name}.csv", sweep / f"{name}.parquet"
    text = ["id", "result"]  # Hexadecimal: without a letter, or with one e, they would be taken for numbers.
    a = pd.read_csv(csv, usecols=columns, dtype=dict.fromkeys(text, str))
    types = dict.fromkeys(text, pl.String) | (pl.read_parquet_schema(parquet) if parquet.exists() else {})
    b = pl.read_csv(csv, columns=columns, schema_overrides=types, infer_schema_length=None)
    if parquet.exists():  # It holds the same, is smaller, and is read several times as fast.
        pd.testing.assert_frame_equal(a, pd.read_parquet(parquet, columns=columns), check_dtype=False, rtol=0, atol=0)
        assert_frame_equal(b, pl.read_parquet(parquet, columns=columns), check_exact=True)
    return a, b


def means(a, b, by, of):
    a = a.groupby(by, as_index=False, dropna=False)[of].mean()
    # pandas leaves NaN out of a mean; Polars leaves out nulls, what is empty in the table.
    b = b.group_by(by).agg(pl.col(of).cast(pl.Float64).fill_nan(None).mean()).sort(by, nulls_last=True)
    pd.testing.assert_frame_equal(a, b.to_pandas(), check_dtype=False, rtol=1e-12)
    return a


def show(table):
    print(table.to_string(index=False, float_format="{:.9g}".format), end="\n\n")


# %% The mean outcome by each key that was swept. A row of results.csv is a run: its keys, its seed, its outcomes.
runs, runs_pl = read("results")
names = list(runs.columns)
keys = names[names.index("id") + 1 : names.index("seed")] or ["seed"]
outcomes = names[names.index("seed") + 1 : names.index("result")]
for key in keys:
    show(means(runs, runs_pl, [key], outcomes))

# %% A score over time by all keys together. A row of generations.csv is a generation of a run, or a robot's interval.
names = pd.read_csv(sweep / "generations.csv", nrows=0).columns
time, score = ("generation", "mean") if "generation" in names else ("interval", "real")
rows, rows_pl = read("generations", ["run", time, score])
joined, joined_pl = rows.merge(runs[["run", *keys]], on="run"), rows_pl.join(runs_pl.select("run", *keys), on="run")
curves = means(joined, joined_pl, [*keys, time], [score])
show(curves[curves[time] == curves[time].max()])
print(f"pandas {pd.__version__} and Polars {pl.__version__} agree on {len(runs)} runs and {len(joined)} rows")
