//! Against the definitions: many poses, many points of a solid, many orders.

use super::*;
use proptest::prelude::*;

/// How many poses stand for a move.
const POSES: u32 = 4000;

fn any_tool() -> impl Strategy<Value = Tool> {
    prop_oneof![
        (0.5..6.0f64).prop_map(flat),
        (0.5..6.0f64).prop_map(ball),
        (0.0..0.5f64, 20.0..120.0f64).prop_map(|(tip, angle)| bit(tip, angle)),
    ]
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    [-3.0..13.0f64, -3.0..13.0f64, -6.0..1.0f64]
}

/// Is a point (m, from the tip) in the cutting end of the tool? Written from the definition alone.
fn inside(tool: &Tool, up: [f64; 3], p: [f64; 3]) -> bool {
    let height: f64 = (0..3).map(|k| up[k] * p[k]).sum();
    let square: f64 = p.iter().map(|v| v * v).sum();
    let radius = libm::sqrt((square - height * height).abs());
    let top = tool.shank.cutting_length_m;
    (0.0..=top).contains(&height) && radius <= tool.radius_at_m(height)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn an_upright_sweep_is_the_least_of_its_poses(tool in any_tool(), a in point(), b in point()) {
        let mut board = Board::new([10.0 * MM; 2], 18.0 * MM, 5.0 * CELL_M).unwrap();
        board.cut(&tool, &upright(a), &upright(b)).unwrap();
        let cell = board.cell_m();
        for (index, got) in board.heights().iter().enumerate() {
            let x = (number(index % board.columns()) + 0.5) * cell;
            let y = (number(index / board.columns()) + 0.5) * cell;
            let mut least = 0.0;
            for k in 0..=POSES {
                let p = blend(a, b, f64::from(k) / f64::from(POSES)).map(|v| v * MM);
                let r = libm::hypot(x - p[0], y - p[1]);
                if let Some(height) = tool.height_m(r) && p[2] + height < least {
                    least = p[2] + height;
                }
            }
            // the poses are at most 6 µm apart, and the board knows no more than they, but for f32
            prop_assert!(f64::from(*got) <= least + 1e-9);
            // where the cutter is steep (the rim of a ball) or ends (that of a flat one) a pose in
            // between reaches a cell that none of them does: then it is one of a tool larger by 6 µm
            let mut lower = 0.0;
            for k in 0..=POSES {
                let p = blend(a, b, f64::from(k) / f64::from(POSES)).map(|v| v * MM);
                let r = libm::hypot(x - p[0], y - p[1]) - 6e-6;
                if let Some(height) = tool.height_m(if r > 0.0 { r } else { 0.0 }) && p[2] + height < lower {
                    lower = p[2] + height;
                }
            }
            prop_assert!(f64::from(*got) >= lower - 6e-6, "{got} {least} {lower} at {x} {y}");
        }
    }

    #[test]
    fn a_tilted_tool_is_the_least_point_of_its_solid(
        tool in any_tool(), lean in -58.0..58.0f64, aside in -10.0..10.0f64, tip in point(),
    ) {
        let stand = pose(tip, aside, lean);
        let stance = Stance::of(&stand).unwrap();
        prop_assume!(stance.up[2] > 0.52);
        let Some(sweep) = TiltedTool::new(&tool, stance.tip, stance.up) else {
            prop_assert!(stance.tip[2] > -1e-12);
            return Ok(());
        };
        for k in 0..15 {
            for l in 0..15 {
                let (x, y) = (f64::from(k) * 0.7 * MM, f64::from(l) * 0.7 * MM);
                let got = sweep.cutter(x, y);
                let from_tip = |z: f64| [x - stance.tip[0], y - stance.tip[1], z - stance.tip[2]];
                // from 12 mm below the board up in steps of 5 µm: the first point inside
                let mut first = None;
                for step in 0..3600 {
                    let z = -12.0 * MM + 5e-6 * f64::from(step);
                    if inside(&tool, stance.up, from_tip(z)) {
                        first = Some(z);
                        break;
                    }
                }
                if let Some(z) = first {
                    prop_assert!(got <= z + 1e-9, "{got} {z}");
                    prop_assert!(got >= z - 5.001e-6 , "{got} {z}");
                    // and what is below the top is where the sweep says it looks
                    if z < 0.0 {
                        let (rows, columns) = (sweep.rows(), sweep.columns(y));
                        prop_assert!(y >= rows.lower && y <= rows.upper);
                        prop_assert!(x >= columns.lower && x <= columns.upper);
                    }
                } else if got < 5.9 * MM {
                    // shorter than a step: its end is just inside, its surroundings are not
                    prop_assert!(!inside(&tool, stance.up, from_tip(got - 1e-6)));
                    prop_assert!(!inside(&tool, stance.up, from_tip(got + 6e-6)));
                }
            }
        }
    }

    #[test]
    fn a_tilt_of_nothing_is_upright(tool in any_tool(), tip in point(), tilt in prop_oneof![Just(0.0), -1e-7..1e-7f64]) {
        let tip = tip.map(|v| v * MM);
        let up = [tilt, 0.0, libm::sqrt(1.0 - tilt * tilt)];
        let (tilted, upright) = (TiltedTool::new(&tool, tip, up), VerticalSweep::new(&tool, tip, tip));
        let (Some(tilted), Some(upright)) = (tilted, upright) else {
            // a tip 1 nm below the top is lower, but for the tilt
            prop_assert!(tip[2] > -1e-9);
            return Ok(());
        };
        for k in 0..20 {
            for l in 0..20 {
                let (x, y) = (f64::from(k) * 0.51 * MM, f64::from(l) * 0.49 * MM);
                // at the rim, of a ball above all, a surface is too steep for a comparison of heights
                let r = libm::hypot(x - tip[0], y - tip[1]);
                if (r - tool.radius_m).abs() < 10e-6 {
                    continue;
                }
                let (a, b) = (tilted.cutter(x, y), upright.cutter(x, y));
                // 1e-7 of 12 mm is 1.2 nm; a wall of a ball 10 µm from its rim rises by 25 to 1
                let nowhere = a.is_infinite() && b.is_infinite();
                prop_assert!(nowhere || (a - b).abs() < 4e-8, "{a} {b}");
            }
        }
    }

    #[test]
    fn heights_never_rise_and_the_order_of_cuts_does_not_matter(
        moves in prop::collection::vec((any_tool(), point(), point(), -30.0..30.0f64), 1..5),
    ) {
        let fresh = Board::new([10.0 * MM; 2], 5.0 * MM, 2.0 * CELL_M).unwrap();
        let mut board = fresh.clone();
        let mut removed = 0.0;
        for (tool, a, b, tilt) in &moves {
            let before = board.clone();
            let cut = board.cut(tool, &upright(*a), &pose(*b, 0.0, *tilt)).unwrap();
            prop_assert!(board.heights().iter().zip(before.heights()).all(|(now, then)| now <= then));
            prop_assert!(board.heights().iter().all(|h| f64::from(*h) >= -5.0 * MM - 1e-9));
            prop_assert!(cut.removed_m3 >= 0.0);
            removed += cut.removed_m3;
        }
        // sums of at most 10⁴ cells, rounded
        prop_assert!((board.removed_m3() - removed).abs() <= 1e-10 * removed + 1e-20);
        let mut backwards = fresh;
        for (tool, a, b, tilt) in moves.iter().rev() {
            backwards.cut(tool, &upright(*a), &pose(*b, 0.0, *tilt)).unwrap();
        }
        prop_assert_eq!(board.digest(), backwards.digest());
    }
}
