"""What a run leaves behind: results as CSV and Parquet, a summary, and plots."""

from cosim.report._plots import plot
from cosim.report._summary import Run, summarize
from cosim.report._tables import write_csv, write_parquet
from cosim.report._write import replacing, write

__all__ = ["Run", "plot", "replacing", "summarize", "write", "write_csv", "write_parquet"]
