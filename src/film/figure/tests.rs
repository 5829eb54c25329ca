use super::*;

fn white(p: Option<Rgb>) -> bool {
    p == Some([255; 3])
}

fn colored(picture: &Raster, color: Rgb) -> Vec<(u32, u32)> {
    let near = |p: Rgb| p.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 24);
    let all = (0..picture.height()).flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
    all.filter(|&(x, y)| picture.pixel(x, y).is_some_and(near)).collect()
}

const RED: Rgb = [255, 0, 0];

fn plot(style: Style, points: &[(f64, f64)]) -> Plot {
    let mut series = Series::new("", style, points.iter().copied());
    series.color = Some(RED);
    Plot { series: vec![series], ..Plot::default() }
}

#[test]
fn a_point_lands_where_the_axes_say() {
    let plot = Plot {
        x: Axis::log("r / mm").with_range(0.01, 100.0),
        y: Axis::linear("R").with_range(-1.0, 3.0),
        ..plot(Style::Markers, &[(0.1, 0.0)])
    };
    let layout = plot.layout().unwrap();
    let frame = layout.frame;
    let x = f64::from(frame.x) + f64::from(frame.width) / 4.0;
    let y = f64::from(frame.bottom()) - f64::from(frame.height) / 4.0;
    let (px, py) = layout.pixel(0.1, 0.0).unwrap();
    assert!((px - x).abs() < 1e-9 && (py - y).abs() < 1e-9, "{px} {py}, not {x} {y}");

    let red = colored(&plot.draw().unwrap(), RED);
    let n = red.len() as f64;
    let mean = |of: fn(&(u32, u32)) -> u32| red.iter().map(|p| f64::from(of(p)) + 0.5).sum::<f64>() / n;
    assert!(n > 20.0 && (mean(|p| p.0) - x).abs() < 0.5 && (mean(|p| p.1) - y).abs() < 0.5);
}

#[test]
fn nothing_is_drawn_outside_of_the_frame() {
    let points: Vec<_> = (-50..50).map(|i| (f64::from(i), f64::from(i * i * i))).collect();
    let error = |&(x, y): &(f64, f64)| Point { x, y, error: 500.0 };
    for style in [Style::Line, Style::Dashed, Style::Markers, Style::LineAndMarkers] {
        let mut plot = plot(style, &points);
        plot.series[0].points =
            points.iter().map(error).chain([Point { x: 1e200, y: -1e250, error: 1.0 }]).collect();
        plot.x.range = Some([-5.0, 5.0]);
        plot.y.range = Some([-20.0, 20.0]);
        let frame = plot.layout().unwrap().frame;
        let red = colored(&plot.draw().unwrap(), RED);
        assert!(red.len() > 100, "{style:?}");
        for (x, y) in red {
            let inside = x >= frame.x && x < frame.right() && y >= frame.y && y < frame.bottom();
            assert!(inside, "{style:?} at {x}, {y}");
        }
    }
}

#[test]
fn a_line_is_cut_at_the_frame_and_interrupted_by_what_cannot_be_shown() {
    let points = [(1.0, 1.0), (2.0, 1.0), (3.0, f64::NAN), (4.0, 1.0), (5.0, 1.0), (6.0, 0.0), (7.0, 1.0)];
    let plot = Plot { y: Axis::log(""), ..plot(Style::Line, &points) };
    let layout = plot.layout().unwrap();
    let picture = plot.draw().unwrap();
    let at = |x: f64| {
        let (x, y) = layout.pixel(x, 1.0).unwrap();
        picture.pixel(x as u32, y as u32)
    };
    assert_eq!([at(1.5), at(4.5), at(7.0)], [Some(RED); 3]);
    assert!([at(2.8), at(3.3), at(5.5), at(6.5)].iter().all(|p| *p != Some(RED)));
}

#[test]
fn whiskers_span_the_standard_error() {
    let mut plot = plot(Style::Markers, &[]);
    plot.series[0].points = vec![(1.0, 2.0, 0.5).into(), (2.0, 3.0, 0.0).into(), (3.0, 1.0, f64::NAN).into()];
    let layout = plot.layout().unwrap();
    let (x, top) = layout.pixel(1.0, 2.5).unwrap();
    let (_, bottom) = layout.pixel(1.0, 1.5).unwrap();
    let column: Vec<_> = colored(&plot.draw().unwrap(), RED)
        .into_iter()
        .filter(|p| (f64::from(p.0) + 0.5 - x).abs() < 2.0)
        .collect();
    let rows = || column.iter().map(|p| f64::from(p.1) + 0.5);
    assert!((rows().fold(f64::MAX, f64::min) - top).abs() < 2.0);
    assert!((rows().fold(f64::MIN, f64::max) - bottom).abs() < 2.0);
}

#[test]
fn the_legend_makes_way_for_the_data() {
    let everywhere: Vec<_> = (0..400).map(|i| (f64::from(i % 20), f64::from(i / 20))).collect();
    let mut plot = plot(Style::Markers, &everywhere);
    let alone = plot.layout().unwrap().frame;
    plot.series[0].name = "everywhere".into();
    let frame = plot.layout().unwrap().frame;
    assert!(frame.right() + 80 < alone.right());
    plot.series[0].points.truncate(20);
    plot.y.range = Some([0.0, 20.0]);
    assert_eq!(plot.layout().unwrap().frame.right(), alone.right());
}

#[test]
fn odd_data_do_not_panic() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-320, f64::MAX, f64::MIN, 1.0];
    let digit = |i: usize, place: u32| odd[i / 10_usize.pow(place) % 10];
    let points: Vec<Point> =
        (0..1000).map(|i| Point { x: digit(i, 0), y: digit(i, 1), error: digit(i, 2) }).collect();
    for (x, y) in [(Scale::Linear, Scale::Log), (Scale::Log, Scale::Linear), (Scale::Log, Scale::Log)] {
        for style in [Style::Line, Style::LineAndMarkers] {
            let mut plot = plot(style, &[]);
            (plot.width, plot.height) = (400, 300);
            (plot.x.scale, plot.y.scale) = (x, y);
            plot.draw().unwrap();
            plot.series[0] = Series::new("odd", style, points.iter().copied());
            plot.draw().unwrap();
            plot.series[0].points.retain(|p| !(p.x.is_finite() && p.y.is_finite()));
            plot.draw().unwrap();
        }
    }
    for (width, height) in [(0, 800), (1200, 0), (40, 40), (u32::MAX, u32::MAX)] {
        let refused = Plot { width, height, ..Plot::default() }.draw();
        assert_eq!(refused, Err(FigureError::Size { width: width.into(), height: height.into() }));
    }
}

fn gray(width: u32, height: u32, value: u8) -> Raster {
    Raster::from_rgb(width, height, vec![value; 3 * (width * height) as usize]).unwrap()
}

fn sheet(n: usize, arrangement: Arrangement) -> Sheet {
    let cell = |i: usize| Cell {
        picture: gray(240, 135, i as u8),
        difference: Some(gray(240, 135, 100 + i as u8)),
        name: format!("model {i}"),
        lines: vec!["1.25 s".into(), "relMSE 0.0031".into()],
    };
    Sheet { cells: (0..n).map(cell).collect(), arrangement, ..Sheet::default() }
}

#[test]
fn sheets_have_the_expected_size_and_cells_do_not_overlap() {
    // Text below the pictures: a gap of 10, a line of 24 and two of 19.
    const TEXT: u32 = 10 + 24 + 2 * 19;
    for (arrangement, cell) in
        [(Arrangement::Below, [240, 2 * 135 + 8 + TEXT]), (Arrangement::Beside, [488, 135 + TEXT])]
    {
        for (n, columns) in [(1, 1), (5, 3), (9, 3)] {
            let mut sheet = sheet(n, arrangement);
            sheet.columns = Some(columns);
            let rows = n.div_ceil(columns) as u32;
            let layout = sheet.layout().unwrap();
            assert_eq!(layout.width, 2 * 28 + columns as u32 * (cell[0] + 28) - 28);
            assert_eq!(layout.height, 2 * 28 + rows * (cell[1] + 28) - 28);
            let picture = sheet.draw().unwrap();
            assert_eq!((picture.width(), picture.height()), (layout.width, layout.height));
            let mut covered = vec![false; (layout.width * layout.height) as usize];
            for rect in &layout.cells {
                for (y, x) in
                    (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (y, x)))
                {
                    assert!(x < layout.width && y < layout.height);
                    assert!(!std::mem::replace(&mut covered[(y * layout.width + x) as usize], true));
                }
            }
            for i in 0..n {
                let (a, b) = (layout.pictures[i], layout.differences[i].unwrap());
                for (rect, value) in [(a, i as u8), (b, 100 + i as u8)] {
                    for (x, y) in [(rect.x, rect.y), (rect.right() - 1, rect.bottom() - 1)] {
                        assert_eq!(picture.pixel(x, y), Some([value; 3]));
                    }
                }
                let text = layout.cells[i].bottom() - TEXT + 10..layout.cells[i].bottom();
                let mut below = text.flat_map(|y| (a.x..a.right()).map(move |x| (x, y)));
                assert!(below.any(|(x, y)| !white(picture.pixel(x, y))), "no text in cell {i}");
            }
        }
    }
}

#[test]
fn the_color_bar_runs_through_the_false_colors() {
    let mut sheet = sheet(2, Arrangement::Below);
    sheet.color_bar = Some(ColorBar { full_scale: 0.05, label: "difference".into() });
    let bar = sheet.layout().unwrap().color_bar.unwrap();
    let picture = sheet.draw().unwrap();
    let middle = bar.y + bar.height / 2;
    let at = |x: u32| picture.pixel(x, middle).unwrap();
    let t = |x: u32| 2.0 * (x as f32 + 0.5) / bar.width as f32 - 1.0;
    for x in [0, 1, bar.width / 3, bar.width / 2, bar.width - 1] {
        assert_eq!(at(bar.x + x), false_color::diverging(t(x)));
    }
}

#[test]
fn odd_sheets_do_not_panic() {
    for arrangement in [Arrangement::Below, Arrangement::Beside] {
        Sheet { arrangement, ..Sheet::default() }.draw().unwrap();
        let mut odd = sheet(4, arrangement);
        odd.cells[1].picture = gray(1, 1, 9);
        odd.cells[2].difference = None;
        odd.cells[3].name = "an-endless-name-".repeat(40);
        odd.title = "A title that is far too long for a single line of so small a sheet ".repeat(9);
        odd.footer = "\n\u{7}\n".into();
        for full_scale in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e-30] {
            odd.color_bar = Some(ColorBar { full_scale, label: String::new() });
            odd.draw().unwrap();
        }
        for columns in [0, 1, 100] {
            odd.columns = Some(columns);
            odd.draw().unwrap();
        }
    }
}

#[test]
fn pictures_are_checked_encoded_and_written_whole() {
    assert_eq!(Raster::from_rgb(2, 2, vec![0; 9]), Err(FigureError::Length { expected: 12, found: 9 }));
    assert!(Raster::from_rgb(0, 2, vec![]).is_err());
    let linear = [Vec3::ZERO, Vec3::splat(0.5), Vec3::new(f32::NAN, f32::INFINITY, -1.0)];
    let picture = Raster::from_linear(3, 1, &linear, |p| p).unwrap();
    assert_eq!(picture.rgb(), [0, 0, 0, 188, 188, 188, 0, 255, 0]);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("figure.png");
    picture.write_png(&path, &[("Software".into(), "nephrite".into())]).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut read = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut read).unwrap();
    assert_eq!(read, picture.rgb());
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
