//! The frame of the page: everything inline, so that one file is all there is and nothing is asked from anywhere.

/// What comes before the body's content; the title is inserted between both parts.
pub(super) const HEAD: [&str; 2] = [
    r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<title>"#,
    r#"</title>
<style>
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin-bottom: 0; } h2 { margin-top: 2.5rem; } h3 { margin: 0; font-size: 1.1rem; }
table { border-collapse: collapse; width: 100%; margin: 0.7rem 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 0.2rem 0.6rem 0.2rem 0; border-bottom: 1px solid #e3e3e3; vertical-align: top; }
th { font-weight: 600; color: #555; } td.n, th.n { text-align: right; }
a { color: #2455a4; } .muted { color: #666; } .small { font-size: 0.88rem; }
.verdict { display: inline-block; min-width: 5.6rem; text-align: center; border-radius: 4px; padding: 0 0.4rem; color: #fff; font-size: 0.85rem; }
.passed { background: #1e7a43; } .failed, .error { background: #b3261e; } .inconclusive { background: #94690a; }
article { border: 1px solid #ddd; border-radius: 8px; padding: 1rem 1.2rem; margin: 1.2rem 0; }
article.bad { border-left: 6px solid #b3261e; }
.pictures { display: flex; flex-wrap: wrap; gap: 1rem; margin: 0.8rem 0; } figure { margin: 0; }
figure img { width: 144px; height: 144px; image-rendering: pixelated; border: 1px solid #ccc; display: block; }
figcaption { font-size: 0.85rem; color: #555; max-width: 150px; }
.scale { width: 144px; height: 8px; background: linear-gradient(to right, #0a55b5, #fff, #b0203a); border: 1px solid #ccc; }
.likely { background: #fff4e5; border-left: 4px solid #e08a00; padding: 0.5rem 0.8rem; margin: 0.6rem 0; }
pre { white-space: pre-wrap; background: #f6f6f6; padding: 0.6rem; overflow-wrap: anywhere; }
.plots { display: flex; flex-wrap: wrap; gap: 1rem; } svg { border: 1px solid #ddd; border-radius: 6px; max-width: 100%; }
svg text { font: 11px system-ui, sans-serif; fill: #444; } svg .mid { text-anchor: middle; } svg .end { text-anchor: end; }
svg .frame { fill: none; stroke: #999; } svg .grid { stroke: #eee; } svg .line { fill: none; stroke-width: 1.5; }
.bar { display: inline-block; height: 0.7em; background: #b3261e; } .rest { display: inline-block; height: 0.7em; background: #1e7a43; }
details summary { cursor: pointer; color: #2455a4; }
</style>
</head>
<body>
"#,
];

/// What comes after it.
pub(super) const FOOT: &str = "</body>\n</html>\n";

/// How to read the page, for somebody who knows nothing of the suite.
pub(super) const READING: &str = "
<details><summary>How to read this</summary>
<p>Each case is a small glTF file whose picture is known: most are slabs, spheres or furnaces for which there is a closed form
or a tabulated solution of radiative transfer, so no renderer is the judge. What is compared are <em>means of linear radiance</em>
over a region, for red, green and blue. In many cases the three channels are three different media.</p>
<p><b>Measured ± error</b>: mean over pixels and independent renders, and its standard error. <b>z</b>: deviation in standard
errors of both numbers (without a standard error, in thirds of the tolerance). A case <b>passes</b> where the deviation is at most the
tolerance plus three standard errors, and that is at most 2 % of what is expected; where noise would hide an error of 2 %, it is
<b>inconclusive</b>: give it more samples.</p>
<p><b>Probably</b>: the measured means are within 3 % of those that this mistake would show in this case, in every channel. They were
computed for each case by a closed form or by simulating the mistake. One case alone may mislead; the same mistake in several cases
hardly does, so begin with the list above.</p></details>
";
