//! The language, move by move; what is refused, word for word.

use super::*;
use crate::cad::nurbs::Nurbs;
use crate::cad::step::{Action, Keeping, Shape, Speed, What, distance};
use proptest::prelude::*;
use std::fmt::Write as _;

fn steps_of(text: &str, most: u64) -> Result<Vec<Step>, DataError> {
    let program = Arc::new(Gcode::new(text.to_owned(), 1e-3, most, true)?);
    program.run().collect()
}

fn steps(text: &str) -> Vec<Step> {
    steps_of(text, 100_000).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// Where the moves of a program end, mm.
fn ends(text: &str) -> Vec<[f64; 3]> {
    let moves = steps(text).into_iter().filter_map(|step| match step.what {
        What::Move(made) => Some(made.to_m.map(|x| libm::round(x * 1e9) / 1e6)),
        What::Action(_) => None,
    });
    moves.collect()
}

fn told(step: &Step) -> String {
    let what = match &step.what {
        What::Action(Action::Spindle {
            clockwise,
            speed_rev_s,
        }) => format!("spindle {clockwise:?} {speed_rev_s:.3}"),
        What::Action(action) => format!("{action:?}"),
        What::Move(made) => {
            let shape = match &made.shape {
                Shape::Line => "line".to_owned(),
                Shape::Arc {
                    centre_m: [x, y, z],
                    angle_rad,
                    ..
                } => format!("arc about {x:.6} {y:.6} {z:.6} by {angle_rad:.6}"),
                Shape::Nurbs(curve) => format!("spline of {:.6}", curve.length_m()),
            };
            let speed = match made.speed {
                Speed::Rapid => "rapid".to_owned(),
                Speed::Feed(feed) => format!("{feed:.6} m/s"),
            };
            let [x, y, z] = made.to_m;
            let keeping = match made.keeping {
                Keeping::Task => String::new(),
                Keeping::Exact => " exactly".to_owned(),
                Keeping::Within(m) => format!(" within {m:.6}"),
            };
            format!("{shape} to {x:.6} {y:.6} {z:.6}, {speed}{keeping}")
        }
    };
    format!("{}: {what}\n", step.line)
}

/// Compares with a file, or writes it if `MRROC_BLESS` is set.
pub(in crate::cad) fn golden(name: &str, got: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("src/cad/golden")
        .join(name);
    if std::env::var_os("MRROC_BLESS").is_some() {
        std::fs::write(&path, got).unwrap();
    }
    let wanted = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(got, wanted, "{}", path.display());
}

#[test]
fn small_programs_are_the_moves_they_say() {
    let programs = [
        "%\nN10 G21 (mm) G90 ; all of it\ng0 z5\nG0 X0 Y0\nS6000 M3 G4 P0.5\nG1 Z-1 F60\nX10 F600\n/X99\nG3 X20 Y10 I0 J10\nG2 X30 Y10 R5 Z-2\nG91 G1 X-1 Y-1\nG64 P0.05 G90 X0 Y0\nG61 X1\nM5 M9\nM30\nG1 X7\n%\nG1 X9\n",
        "G20 G0 X0 Y0 Z0\nG93 G1 X1 F2\nX2 F4\nG94 F30 X1\n",
        "G0 X0 Y0 Z0 F100\nG18 G2 X10 Z0 I5 K0\nG19 G3 Y10 Z0 J5\nG17 G90.1 G2 X10 Y10 I10 J5\nG91.1 G3 I1 J0 P3\n",
        "G0 X0 Y0 Z0 F100\nG5 I0 J3 P0 Q-3 X1 Y1\nG5 P0 Q-3 X2 Y2\nG5.1 X4 Y2 I1 J1\nG5.2 P1 L4\nX5 Y4 P2\nX6 Y4 P1\nX7 Y2\nG5.3\nT2 M6\nM0\nM1\nM2",
        "#1=2\n#<a>=[#1*3]\nG0 X#<a> Y[2**3**2] Z[7 mod 4]\nX[-[atan[1]/[1]]] Y[sqrt[16] + abs[-2] * fix[2.7]] Z[1 gt 2 or 3 le 3]\n#2=[round[2.5] / fup[1.2]]\nX#2 Y[exists[#<a>]] Z[exists[#<b>]]\n",
    ];
    let told: Vec<String> = programs
        .into_iter()
        .map(|text| steps(text).iter().map(told).collect())
        .collect();
    golden("programs.txt", &told.join("\n"));
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of mistakes")]
fn whatever_is_not_understood_is_refused_with_its_place() {
    let before = "G0 X0 Y0 Z0\n";
    let programs = [
        "G1 X1",
        "G1 X1 Y1 Z1 F1 A3",
        "G1 X",
        "G1 X1 X2",
        "G0 G1 X1",
        "G1 X1e3 F1",
        "G28",
        "G30",
        "G41 D1",
        "G10 L2",
        "G92 X0",
        "G53 G0 X1",
        "G81 Z1 R1",
        "G33 K1",
        "G38.2 Z1",
        "G43.1 K1",
        "G95",
        "G96 S1",
        "G12.34",
        "M6",
        "M66",
        "M99",
        "F0 G1 X1",
        "F-1",
        "F1e",
        "S-1",
        "T1.5",
        "G4",
        "G4 P-1",
        "G80\nX1",
        "G1 F1 X99999999",
        "G55 G0 X1\nG56 X2",
        "G2 X1",
        "G2 F1 X1 Y0 R0.1",
        "G2 F1 X0 Y0 R1",
        "G2 F1 X1 I9",
        "G2 F1 X1 I1 K1",
        "G2 F1 X1 I1 R1",
        "G90.1 G2 F1 X1 I1",
        "G2 F1 X2 I1 P0",
        "G18 G5 F1 X1 I1 J1 P1 Q1",
        "G5 F1 X1 P1 Q1",
        "G5 F1 X1 I1 J1 P1",
        "G5.1 F1 X1 I1",
        "G5 F1 Z1 I1 J1 P1 Q1",
        "G5.3",
        "F1 G5.2 X1\nG0 X2",
        "F1 G5.2 X1 Y1\nX2\n",
        "F1 G5.2 X1 Y1\nG5.3",
        "F1 G5.2 X1 P0",
        "F1 G5.2 X1 L99",
        "F1 G5.2 X1\nM5",
        "F1 G93 G1 X1\nX2",
        "G64 P-1",
        "G1 F1 X1 R2",
        "M3 Q1",
        "#1",
        "#1=",
        "#0=1",
        "#5001=1",
        "X#<none>",
        "#<a b=1",
        "#<ż>=1",
        "X[1",
        "X[1+",
        "X[1/0]",
        "X[foo[1]]",
        "X[sqrt[-1]]",
        "X[atan[1]]",
        "X[ln 1]",
        "(open",
        "(a (b)",
        "X[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]",
        "Ó1",
        "$",
        "o",
        "o1",
        "o1 what",
        "o1 sub",
        "o1 endsub",
        "o1 if [1]\no2 endif",
        "o1 call",
        "o1 break",
        "o1 if 1\no1 endif",
        "o1 if [1] X1\no1 endif",
        "o1 sub\no2 sub",
        "o1 sub\no1 endsub\no1 sub\no1 endsub",
        "o1 sub\no1 call\no1 endsub\no1 call",
        "o1 while [1]\no1 endwhile",
        "o1 return",
        "o1 repeat [1]",
        "G1 X1.2.3 F1",
        "N G1",
        "G0 G20 G21",
        "M3 M4",
    ];
    let mut told = String::new();
    for text in programs {
        let text = format!("{before}{text}");
        let error = steps_of(&text, 10_000).expect_err(&text);
        assert!(error.line >= 2 && error.column >= 1, "{text}: {error}");
        writeln!(told, "{:?}\n    {error}", &text[before.len()..]).unwrap();
    }
    golden("refusals.txt", &told);
}

#[test]
fn subroutines_have_parameters_of_their_own_and_come_back() {
    let factorial = "o<f> sub\no1 if [#1 le 1]\n#<_r>=1\no1 else\no<f> call [#1-1]\n#<_r>=[#<_r>*#1]\no1 endif\no<f> endsub\n\
        #1=77\no<f> call [5]\nG0 X#<_r> Y#1 Z0\n";
    assert_eq!(ends(factorial), [[120.0, 77.0, 0.0]]);
    let value = "o1 sub\no1 return [#1+#2]\no1 endsub [0]\no1 call [2] [3]\nG0 X#<_value> Y0 Z0";
    assert_eq!(ends(value), [[5.0, 0.0, 0.0]]);
    // assigned at the end of the line, as RS-274 has it
    assert_eq!(
        ends("#3=15\n#3=6 G0 X#3 Y0 Z0\nX#3"),
        [[15.0, 0.0, 0.0], [6.0, 0.0, 0.0]]
    );
}

#[test]
fn loops_and_branches_do_what_their_words_say() {
    let x = |text: &str| {
        let ends = ends(&format!("G0 Y0 Z0\n{text}"));
        ends.into_iter().map(|[x, ..]| x).collect::<Vec<_>>()
    };
    assert_eq!(
        x("#1=0\no1 while [#1 lt 3]\nX#1\n#1=[#1+1]\no1 endwhile"),
        [0.0, 1.0, 2.0]
    );
    assert_eq!(
        x("#1=0\no1 do\nX#1\n#1=[#1+1]\no1 while [#1 lt 3]"),
        [0.0, 1.0, 2.0]
    );
    assert_eq!(x("#1=5\no1 do\nX#1\no1 while [0]"), [5.0]);
    assert_eq!(
        x("o1 repeat [2]\no2 repeat [2]\n#1=[#1+1] X#1\no2 endrepeat\no1 endrepeat"),
        [0.0, 1.0, 2.0, 3.0]
    );
    assert_eq!(x("o1 repeat [0]\nX1\no1 endrepeat\nX9"), [9.0]);
    assert_eq!(
        x(
            "o1 while [1]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\no3 if [#1 gt 3]\no1 break\no3 endif\nX#1\no1 endwhile"
        ),
        [1.0, 3.0]
    );
    let branch = "o1 if [#1 eq 0]\nX0\no1 elseif [#1 eq 1]\nX1\no1 elseif [#1 eq 2]\nX2\no1 else\nX3\no1 endif";
    for k in 0..=3 {
        assert_eq!(x(&format!("#1={k}\n{branch}")), [f64::from(k)]);
    }
    // out of a repetition within, which begins anew the next time
    assert_eq!(
        x(
            "#2=0\no1 repeat [2]\no2 repeat [3]\n#2=[#2+1] X#2\no2 break\no2 endrepeat\no1 endrepeat"
        ),
        [0.0, 1.0]
    );
    assert_eq!(x("o1 repeat [2]\no1 continue\nX1\no1 endrepeat\nX4"), [4.0]);
}

/// The basis functions of a B-spline by their recursion (de Boor, *A Practical Guide to Splines*, IX (14)).
fn basis(k: usize, i: usize, t: f64, knots: &[f64]) -> f64 {
    if k == 1 {
        let last = t >= knots[knots.len() - 1] && knots[i + 1] >= t && knots[i] < t;
        return f64::from(u8::from((knots[i] <= t && t < knots[i + 1]) || last));
    }
    let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    part(t - knots[i], knots[i + k - 1] - knots[i]) * basis(k - 1, i, t, knots)
        + part(knots[i + k] - t, knots[i + k] - knots[i + 1]) * basis(k - 1, i + 1, t, knots)
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    (-0.1_f64..0.1, -0.1_f64..0.1).prop_map(|(x, y)| [x, y, 0.0])
}

proptest! {
    #[test]
    fn splines_are_the_sums_of_their_basis_functions(
        control in prop::collection::vec((point(), 0.2_f64..5.0), 4..9), order in 2_usize..5, share in 0.0_f64..=1.0,
    ) {
        let curve = Nurbs::clamped(order, control.clone()).unwrap();
        let spans = control.len() + 1 - order;
        let knots: Vec<f64> = (0..control.len() + order)
            .map(|k| f64::from(u32::try_from((k + 1).saturating_sub(order).min(spans)).unwrap()))
            .collect();
        let t = share * knots[knots.len() - 1];
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (i, (at, weight)) in control.iter().enumerate() {
            let part = weight * basis(order, i, t, &knots);
            weights += part;
            for (sum, x) in sum.iter_mut().zip(at) {
                *sum += part * x;
            }
        }
        // both round some hundred times numbers below 0.1
        let off = distance(&curve.at(share), &sum.map(|x| x / weights));
        prop_assert!(off < 1e-13, "{off}");
    }

    #[test]
    fn an_arc_by_its_radius_is_the_arc_by_its_centre(
        [x, y, _] in point(), from in 0.0_f64..6.2, angle in 0.05_f64..6.2, r in 1e-3_f64..0.1, clockwise: bool,
    ) {
        prop_assume!((angle - core::f64::consts::PI).abs() > 0.01);
        let turn = if clockwise { -angle } else { angle };
        let at = |t: f64| [1e3 * (x + r * libm::cos(t)), 1e3 * (y + r * libm::sin(t))];
        let ([x0, y0], [x1, y1]) = (at(from), at(from + turn));
        let code = if clockwise { 2 } else { 3 };
        let (i, j) = (1e3 * x - x0, 1e3 * y - y0);
        let signed = 1e3 * if angle > core::f64::consts::PI { -r } else { r };
        let begin = format!("F1 G0 X{x0:.12} Y{y0:.12} Z0\nG{code} X{x1:.12} Y{y1:.12}");
        let arc = |words: String| match steps(&format!("{begin} {words}")).remove(1).what {
            What::Move(made) => made,
            What::Action(_) => unreachable!(),
        };
        let (centre, radius) = (arc(format!("I{i:.12} J{j:.12}")), arc(format!("R{signed:.12}")));
        for k in 0..=8 {
            let share = f64::from(k) / 8.0;
            let true_at = at(from + turn * share).map(|x| 1e-3 * x);
            let wanted = [true_at[0], true_at[1], 0.0];
            // twelve digits of mm; near half a turn, or of a short arc, a radius says a hundred times less
            prop_assert!(distance(&centre.at(share), &wanted) < 1e-11);
            prop_assert!(distance(&radius.at(share), &wanted) < 1e-9);
        }
    }

    #[test]
    fn any_text_is_a_program_or_one_line_about_it(text in "(?s).{0,200}") {
        let _ = one_line(&text);
    }

    #[test]
    fn any_words_are_a_program_or_one_line_about_it(
        words in prop::collection::vec(
            prop::sample::select(vec![
                "G0", "G1", "G2", "G3", "G5", "G5.2", "G5.3", "X1", "Y", "Z[1]", "I1", "J0", "R2", "P1", "F10", "\n", "\n", "\n",
                "o1 ", "o2 ", "sub", "endsub", "call", "if [1]", "if [#1]", "else", "endif", "while [#1 lt 3]", "endwhile", "do",
                "repeat [3]", "endrepeat", "break", "continue", "return", "#1=[#1+1]", "#<a>=2", "#", "[", "]", "(", ")", "%", "M2",
                "/", ";", "*", "**", "-", "mod", "\u{17c}",
            ]),
            0..60,
        )
    ) {
        one_line(&words.concat())?;
    }
}

fn one_line(text: &str) -> Result<(), TestCaseError> {
    if let Err(error) = steps_of(text, 2000) {
        prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error);
    }
    Ok(())
}

/// The recursion of the program, in its own words.
fn snake(level: u32, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], out: &mut Vec<[f64; 2]>) {
    if level == 0 {
        out.push([x1, y1]);
        return;
    }
    let root = libm::sqrt(12.0);
    let a = [(x0 * 2.0 + x1) / 3.0, (y0 * 2.0 + y1) / 3.0];
    let b = [
        f64::midpoint(x0, x1) + (y1 - y0) / root,
        f64::midpoint(y0, y1) - (x1 - x0) / root,
    ];
    let c = [(x0 + 2.0 * x1) / 3.0, (y0 + 2.0 * y1) / 3.0];
    let points = [[x0, y0], a, b, c, [x1, y1]];
    for pair in points.windows(2) {
        snake(level - 1, pair[0], pair[1], out);
    }
}

#[test]
fn a_flowsnake_is_that_of_its_recursion() {
    let Some(path) = crate::cad::test::real("flowsnake.ngc") else {
        return;
    };
    let corners = [[0.25, 1.0], [3.75, 1.0], [2.0, 3.95], [0.25, 1.0]];
    let mut wanted = Vec::new();
    for pair in corners.windows(2) {
        snake(5, pair[0], pair[1], &mut wanted);
    }
    let text = std::fs::read_to_string(path).unwrap();
    let got: Vec<[f64; 3]> = steps(&text)
        .into_iter()
        .filter_map(|step| match step.what {
            What::Move(made) if made.speed != Speed::Rapid => Some(made.to_m),
            _ => None,
        })
        .collect();
    // the first cut is the plunge
    assert_eq!(got.len(), wanted.len() + 1);
    for (got, [x, y]) in got.iter().skip(1).zip(wanted) {
        // both round the same expressions of numbers below 4, here in mm
        assert!(distance(got, &[1e-3 * x, 1e-3 * y, 0.0]) < 1e-15);
    }
}
