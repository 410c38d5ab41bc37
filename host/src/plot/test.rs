use super::drawing::Shape as Drawn;
use super::*;
use crate::error::exit;

/// A run of two arms that never was: steps, smooth motions, small errors.
fn synthetic() -> PlotData {
    let names = [
        "track [m]",
        "column",
        "lower arm",
        "upper arm",
        "wrist T",
        "wrist V",
        "wrist N",
    ];
    let robot = |name: &str, axes: &[&str], phase: f64| {
        let time_s: Vec<f64> = (0..9000).map(|i| 0.006 * f64::from(i)).collect();
        let smooth = |t: f64| {
            let s = (t - 10.0) / 30.0;
            let s = s.clamp(0.0, 1.0);
            s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        };
        let tool = |t: f64, off: f64| {
            let a = 4.0 * smooth(t) + phase;
            [
                0.9 + 0.3 * libm::cos(a) + off,
                0.2 + 0.35 * libm::sin(a),
                0.3 + 0.2 * libm::sin(2.0 * a) + off,
            ]
        };
        RobotPlot {
            name: name.into(),
            axes: axes
                .iter()
                .zip(0u8..)
                .map(|(name, k)| {
                    let k = f64::from(k);
                    let at = |t: f64| libm::sin(0.9 * k + phase) * 1.5 + libm::cos(k) * smooth(t);
                    let error = |t: f64| {
                        0.02 * (k + 1.0) / 7.0
                            * libm::sin(0.7 * t + k)
                            * smooth(t)
                            * (1.0 - smooth(t))
                            * 4.0
                    };
                    AxisPlot {
                        name: (*name).into(),
                        setpoint: time_s.iter().map(|t| at(*t)).collect(),
                        actual: time_s.iter().map(|t| at(*t) - error(*t)).collect(),
                        following_error_rad: time_s.iter().map(|t| error(*t)).collect(),
                    }
                })
                .collect(),
            tool_setpoint_m: time_s.iter().map(|t| tool(*t, 0.0)).collect(),
            tool_actual_m: time_s.iter().map(|t| tool(*t, 0.004)).collect(),
            time_s,
        }
    };
    PlotData {
        title: "Two arms: taught sequence, lines, a carried object".into(),
        robots: vec![
            robot("irp6-track", &names, 0.0),
            robot("irp6-postument", &names[1..], 1.0),
        ],
        steps: [
            (0.0, "home irp6-track, irp6-postument"),
            (9.0, "first poses"),
            (9.4, "wait 0.4 s"),
            (24.0, "replay irp6-track, irp6-postument"),
            (41.0, "straight lines"),
            (48.0, "carry <object> & turn"),
        ]
        .map(|(time_s, name)| StepMark {
            time_s,
            name: name.into(),
        })
        .to_vec(),
    }
}

#[test]
fn the_picture_is_well_formed_and_the_same_every_time() {
    let data = synthetic();
    let picture = svg(&Picture::from(&data));
    assert_eq!(picture, svg(&Picture::from(&data)));
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
    assert!(picture.contains("carry &lt;object&gt; &amp; turn"));
    assert!(picture.contains(">irp6-postument</text>"));
    assert!(!picture.contains("NaN") && !picture.contains("inf"));
    // two robots with two lines and one per axis, and twice two tool paths; each line is decimated
    let longest = picture
        .lines()
        .map(|line| line.matches(',').count())
        .max()
        .unwrap();
    assert!((500..=decimate::MAX_POINTS).contains(&longest), "{longest}");
    let lines = picture.matches("stroke-dasharray=\"5 3\"").count();
    // 13 axes, 4 views, 2 legends
    assert_eq!(lines, 13 + 4 + 2);
}

#[test]
fn a_long_title_is_smaller_but_whole() {
    let mut data = synthetic();
    let size = |data: &PlotData| {
        let Drawn::Text(title) = Picture::from(data)
            .0
            .shapes
            .into_iter()
            .find(|shape| matches!(shape, Drawn::Text(text) if text.words == data.title))
            .unwrap()
        else {
            unreachable!()
        };
        let right = title.at[0] + font::width(&title.words, title.size);
        (title.size, right, Picture::from(data).0.width)
    };
    let (short, ..) = size(&data);
    data.title = data.title.repeat(4);
    let (long, right, width) = size(&data);
    assert!(long < short, "{long} {short}");
    // to the last letter: as wide as there is room, between equal margins
    assert!((right - (width - 24.0)).abs() < 1e-9, "{right} {width}");
}

#[test]
fn both_kinds_of_file_are_written() {
    let data = Picture::from(&synthetic());
    let folder = std::env::temp_dir().join(format!("mrroc-plot-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    save(&data, &folder.join("run.svg")).unwrap();
    save(&data, &folder.join("run.png")).unwrap();
    let bytes = std::fs::read(folder.join("run.png")).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let size = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(size(16), 2580);
    assert!((1400..2200).contains(&size(20)), "{}", size(20));
    assert_eq!(
        std::fs::read_dir(&folder).unwrap().count(),
        2,
        "no part is left"
    );
    if let Some(kept) = std::env::var_os("MRROC_PLOT_DEMO") {
        std::fs::copy(
            folder.join("run.png"),
            Path::new(&kept).with_extension("png"),
        )
        .unwrap();
        std::fs::copy(
            folder.join("run.svg"),
            Path::new(&kept).with_extension("svg"),
        )
        .unwrap();
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_empty_run_and_wrong_numbers_make_a_picture_too() {
    let mut data = PlotData::default();
    assert!(svg(&Picture::from(&data)).contains("<svg"));
    assert!(png(&Picture::from(&data)).is_ok());
    data.robots.push(RobotPlot {
        name: "a\u{0}b".into(),
        time_s: vec![0.0, f64::NAN, 1.0],
        axes: vec![AxisPlot {
            name: "x".into(),
            setpoint: vec![f64::INFINITY, 1.0],
            actual: vec![],
            following_error_rad: vec![f64::NAN; 9],
        }],
        tool_setpoint_m: vec![[f64::NAN; 3]],
        tool_actual_m: vec![],
    });
    data.steps.push(StepMark {
        time_s: f64::NAN,
        name: String::new(),
    });
    let picture = svg(&Picture::from(&data));
    assert!(!picture.contains("NaN,") && !picture.contains("inf") && !picture.contains('\u{0}'));
    assert!(png(&Picture::from(&data)).is_ok());
}

#[test]
fn other_endings_and_places_are_refused() {
    let data = Picture::from(&PlotData::default());
    let error = save(&data, Path::new("run.jpg")).unwrap_err();
    assert_eq!(error.exit_code(), exit::USAGE);
    assert_eq!(
        error.to_string(),
        "unknown kind of picture (expected a name that ends in .svg or .png, got `run.jpg`)"
    );
    assert!(check_name(Path::new("a.PNG")).is_ok());
    assert!(check_name(Path::new("svg")).is_err());
    let error = save(&data, Path::new("/no/such/folder/run.svg")).unwrap_err();
    assert_eq!(error.exit_code(), exit::CANNOT_CREATE);
}
