"""Results folders, read when they are asked for."""
import collections.abc, csv, functools, html, json, pathlib

try:
    import numpy
except ImportError:
    numpy = None


contact_columns = ("gap_", "contact_", "pairs_", "principal_stress_", "friction_", "normal_")


def column_of(cells):
    """Numbers, an empty cell nan; texts where a cell is no number."""
    try:
        numbers = [float(cell) if cell else float("nan") for cell in cells]
    except ValueError:
        return cells
    return numpy.array(numbers) if numpy else numbers


class Table(collections.abc.Mapping):
    """A CSV file: columns by their names in its first line, numpy arrays where numpy is installed, else lists. The file is
    read at the first question."""

    def __init__(self, path):
        self.path = pathlib.Path(path)

    @functools.cached_property
    def cells(self):
        with open(self.path, newline="") as file:
            rows = list(csv.reader(file))
        names = rows[0] if rows else []
        return {name: [row[i] for row in rows[1:]] for i, name in enumerate(names)}

    @functools.cache
    def column(self, name):
        return column_of(self.cells[name])

    def __getitem__(self, name):
        if name not in self.cells:
            raise KeyError(f"{self.path} has no column {name!r}; it has {', '.join(self.cells)}")
        return self.column(name)

    def __iter__(self):
        return iter(self.cells)

    def __len__(self):
        return len(self.cells)

    __hash__ = object.__hash__

    def __repr__(self):
        return f"Table({str(self.path)!r}): {', '.join(self.cells)}"

    def frame(self):
        """A pandas DataFrame."""
        import pandas
        return pandas.DataFrame(dict(self))


class Columns(collections.abc.Mapping):
    """Those columns of a table whose names begin so."""

    def __init__(self, table, beginnings):
        self.table, self.beginnings = table, beginnings

    def __getitem__(self, name):
        if not name.startswith(self.beginnings):
            raise KeyError(f"{name!r} is no column of these; they are {', '.join(self)}")
        return self.table[name]

    def __iter__(self):
        return (name for name in self.table if name.startswith(self.beginnings))

    def __len__(self):
        return sum(1 for _ in self)

    def frame(self):
        return Table.frame(self)


class Page:
    """A page that a notebook shows."""

    def __init__(self, path, height):
        self.path, self.height = path, height

    def _repr_html_(self):
        text = html.escape(self.path.read_text(), quote=True)
        return f'<iframe srcdoc="{text}" width="100%" height="{self.height}" style="border: 0"></iframe>'

    def __repr__(self):
        return f"the page {self.path}"


class Folder:
    """What runs and studies have in common. `text`: what the command printed, where it was called from here."""

    def __init__(self, folder, text=""):
        self.folder, self.text = pathlib.Path(folder), text
        if not (self.folder / self.index).is_file():
            raise FileNotFoundError(f"{self.folder} has no {self.index}; allowed: a results folder of `ricochet {self.by}`")

    def __repr__(self):
        return f"{type(self).__name__}({str(self.folder)!r})"

    def table(self, name, made_by):
        path = self.folder / name
        if not path.is_file():
            raise FileNotFoundError(f"{path} is not there; {made_by} of the scene writes it")
        return Table(path)

    def show(self, height=800):
        """The report, for the last line of a cell of a notebook."""
        return Page(self.folder / "report.html", height)


class Result(Folder):
    """The results folder of a run."""
    index, by = "summary.json", "run"

    @functools.cached_property
    def summary(self):
        """summary.json as a dict: docs/results.md has its keys."""
        return json.loads((self.folder / "summary.json").read_text())

    @functools.cached_property
    def history(self):
        """history.csv: contact, energies, momentum over time."""
        return self.table("history.csv", "a run that is accepted")

    @functools.cached_property
    def probes(self):
        """probes.csv: points of bodies over time."""
        return self.table("probes.csv", "a table [[output.probe]]")

    @functools.cached_property
    def axial_stress(self):
        """axial_stress.csv: stress waves by time and position."""
        return self.table("axial_stress.csv", "the key output.axial_stress_every")

    @functools.cached_property
    def contact(self):
        """The columns of `history` that tell of contact, and its time."""
        return Columns(self.history, ("time_s", *contact_columns))


class Study(Folder):
    """The results folder of a study."""
    index, by = "study.json", "study"

    @functools.cached_property
    def description(self):
        """study.json as a dict."""
        return json.loads((self.folder / "study.json").read_text())

    @functools.cached_property
    def results(self):
        """results.csv: a row for each run."""
        return self.table("results.csv", "a study")

    def result(self, row, repeat=1):
        """The Result of the run of that row."""
        return Result(self.folder / "runs" / self.results.cells["run"][row] / str(repeat))
