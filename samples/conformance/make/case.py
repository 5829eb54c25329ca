"""A case as it is written to a folder: the asset, `expect.toml`, and a README that says the same in words."""
import dataclasses
import json

import numpy as np

from document import Document, number, numbers

GENERATOR = "nephrite samples/conformance/make"
# A symptom that is nearer than this to what is right, in every channel, tells nothing.
TELLING = 0.03


@dataclasses.dataclass
class Expect:
    """A mean that a region must have."""

    name: str
    mean: list
    source: str
    tolerance: float
    why: str
    region: list = None
    standard_error: list = None
    symptoms: list = dataclasses.field(default_factory=list)

    def symptom(self, mean, says):
        """What a renderer with that mistake shows, unless it can hardly be told from what is right."""
        mean = np.broadcast_to(np.asarray(mean, float), 3)
        # The mean of a reference is not known here: such a symptom is taken as it is.
        right = np.asarray(mean if self.mean is None else self.mean)
        told = np.abs(mean - right) > TELLING * np.maximum(np.abs(right), 1e-9)
        if (self.mean is None or told.any()) and all(other != says for _, other in self.symptoms):
            self.symptoms.append((numbers(np.round(mean, 4)), says))
        return self


@dataclasses.dataclass
class Case:
    """A folder of the suite."""

    name: str
    title: str
    tests: list
    text: str
    size: int = 16
    spp: int = 1024
    expects: list = dataclasses.field(default_factory=list)
    sweep: tuple = None
    environment: list = None
    reference: str = None
    same_as: str = None
    others: str = None
    document: Document = dataclasses.field(default_factory=lambda: Document(GENERATOR))

    def under(self, radiance):
        """Puts the scene into a uniform environment."""
        self.document.environment(radiance)
        self.environment = [radiance] * 3
        return self

    def expect(self, *args, **more):
        self.expects.append(Expect(*args, **more))
        return self.expects[-1]

    def write(self, suite):
        folder = suite / self.name
        folder.mkdir(exist_ok=True)
        self.document.write(folder, self.name)
        (folder / "expect.toml").write_text(self.toml())
        (folder / "README.md").write_text(self.readme())

    def toml(self):
        lines = ["# Written by samples/conformance/make/build.py."]
        put = lambda key, value: lines.append(f"{key} = {toml(value)}")
        put("title", self.title)
        put("tests", self.tests + ["refracting boundary"] * self.document.refracts())
        put("width", self.size)
        put("height", self.size)
        put("spp", self.spp)
        if self.environment:
            put("environment", numbers(self.environment))
        if self.same_as:
            put("same_as", self.same_as)
        if self.reference:
            put("reference", self.reference)
        if self.others:
            put("other_renderers", self.others)
        if self.sweep:
            name, parameter, values = self.sweep
            lines += ["", "[sweep]"]
            put("name", name)
            put("parameter", parameter)
            put("values", numbers(values))
        for expect in self.expects:
            lines += ["", "[[expect]]"]
            put("name", expect.name)
            if expect.region:
                put("region", expect.region)
            if expect.mean is not None:
                put("mean", numbers(expect.mean))
            if expect.standard_error is not None:
                put("standard_error", numbers(expect.standard_error))
            put("source", expect.source)
            put("tolerance", expect.tolerance)
            put("why", expect.why)
            for mean, says in expect.symptoms:
                lines += ["", "[[expect.symptom]]"]
                put("mean", mean)
                put("says", says)
        return "\n".join(lines) + "\n"

    def readme(self):
        lines = [f"# {self.title}", "", self.text.strip(), "", "## Expected", ""]
        if self.expects[0].mean is None:
            lines += ["The converged random walk of nephrite, `reference.exr`: the means of these regions and their standard "
                      "errors are in `reference.toml`.", ""]
            for e in self.expects:
                lines.append(f"- {e.name}" + (f": {e.region[2]} × {e.region[3]} pixels at ({e.region[0]}, {e.region[1]})" if e.region else ""))
            lines.append("")
        else:
            lines += ["| Where | Red | Green | Blue | Tolerance | Source |", "| --- | --- | --- | --- | --- | --- |"]
            for e in self.expects:
                where = e.name if e.region is None else f"{e.name}, {e.region[2]} × {e.region[3]} pixels at ({e.region[0]}, {e.region[1]})"
                values = " | ".join(f"{v:.5g}" for v in e.mean)
                lines.append(f"| {where} | {values} | {e.tolerance:.2%} | {e.source} |")
            lines.append("")
        whys = list(dict.fromkeys(e.why for e in self.expects))
        lines += ["Tolerance: " + " ".join(whys), ""]
        symptoms = [(e, m, s) for e in self.expects for m, s in e.symptoms]
        if symptoms:
            lines += ["## What a wrong implementation shows", "", "| Red | Green | Blue | Probably |", "| --- | --- | --- | --- |"]
            for expect, mean, says in symptoms:
                where = f" ({expect.name})" if len(self.expects) > 1 else ""
                lines.append("| " + " | ".join(f"{v:.4g}" for v in mean) + f" | {says}{where} |")
            lines.append("")
        if self.same_as:
            lines += [f"The picture must be that of [{self.same_as}](../{self.same_as}/README.md). If that case passes and this "
                      "one does not, the difference between the two files is what is read wrongly.", ""]
        if self.others:
            lines += ["## Other renderers", "", self.others, ""]
        return "\n".join(lines)


def toml(value):
    """JSON's strings, numbers and arrays are TOML's, too."""
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return f"{value:.1f}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    return json.dumps(value, ensure_ascii=False) if not isinstance(value, float) else repr(number(value))
