use super::*;
use nalgebra::Vector3;
use proptest::prelude::*;

const MM: f64 = 1e-3;

fn shank() -> Shank {
    Shank {
        cutting_length_m: 12.0 * MM,
        diameter_m: 6.0 * MM,
        stick_out_m: 30.0 * MM,
        holder_diameter_m: 40.0 * MM,
    }
}

fn tool(cutter: Cutter) -> Tool {
    Tool::new(cutter, shank()).unwrap()
}

fn flat(mm: f64) -> Tool {
    tool(Cutter::Flat {
        diameter_m: mm * MM,
    })
}

fn ball(mm: f64) -> Tool {
    tool(Cutter::Ball {
        diameter_m: mm * MM,
    })
}

fn bit(tip_mm: f64, degrees: f64) -> Tool {
    tool(Cutter::V {
        tip_m: tip_mm * MM,
        angle_rad: degrees.to_radians(),
    })
}

/// A tool whose tip is at a point (mm), upright but for a turn about x and one about y (degrees).
fn pose(mm: [f64; 3], about_x: f64, about_y: f64) -> Pose {
    let tip = Vector3::from(mm) * MM;
    let turn = |w: Vector3<f64>| Pose::from_rotation_vector(Vector3::zeros(), w);
    let mut pose = turn(Vector3::x() * about_x.to_radians())
        * turn(Vector3::y() * about_y.to_radians())
        * turn(Vector3::x() * core::f64::consts::PI);
    pose.position = tip;
    pose
}

fn upright(mm: [f64; 3]) -> Pose {
    pose(mm, 0.0, 0.0)
}

fn board(x_mm: f64, y_mm: f64) -> Board {
    Board::new([x_mm * MM, y_mm * MM], 18.0 * MM, CELL_M).unwrap()
}

/// The height of the cell that holds a point (mm).
fn at(board: &Board, x: f64, y: f64) -> f64 {
    let (column, row) = ((x * MM / CELL_M) as usize, (y * MM / CELL_M) as usize);
    f64::from(board.heights()[row * board.columns() + column])
}

/// The number of cells in the column of cells at x (mm) that are lower than −0.1 µm.
fn width(board: &Board, x: f64) -> f64 {
    let column = (x * MM / CELL_M) as usize;
    let cut = board.heights().iter().skip(column).step_by(board.columns());
    cut.filter(|h| **h < -1e-7).count() as f64 * CELL_M
}

#[test]
fn a_slot_of_a_flat_mill_has_its_width_depth_and_volume() {
    let mut board = board(60.0, 20.0);
    let tool = flat(6.0);
    let cut = board
        .cut(
            &tool,
            &upright([10.0, 10.0, -2.0]),
            &upright([50.0, 10.0, -2.0]),
        )
        .unwrap();
    // the edge of a cut is known to half a cell on either side
    assert!((width(&board, 30.0) - 6.0 * MM).abs() <= 1.001 * CELL_M);
    assert!((at(&board, 30.0, 10.0) + 2.0 * MM).abs() < 1e-9);
    assert!((cut.depth_m - 2.0 * MM).abs() < 1e-12);
    let area = 40.0 * 6.0 + core::f64::consts::PI * 9.0;
    let volume = area * 2.0 * MM * MM * MM;
    // half a cell around the whole edge, and no more than 1 % of it
    assert!((cut.removed_m3 / volume - 1.0).abs() < 0.01, "{cut:?}");
    assert!((board.removed_m3() / cut.removed_m3 - 1.0).abs() < 1e-9);
    assert_eq!((cut.through, cut.collision), (None, None));
    // the ends are round: beyond the end by 2.9 mm it is cut, by 3.1 mm it is not, in the corner neither
    assert!(at(&board, 52.85, 10.0) < 0.0 && at(&board, 53.15, 10.0) >= 0.0);
    assert!(at(&board, 52.5, 12.5) >= 0.0);
}

#[test]
fn a_v_groove_is_as_wide_as_its_angle_says() {
    for (tip, degrees, depth) in [(0.0, 60.0, 1.5), (0.2, 30.0, 3.0), (0.1, 90.0, 0.5)] {
        let mut board = board(30.0, 20.0);
        let (from, to) = (upright([5.0, 10.0, -depth]), upright([25.0, 10.0, -depth]));
        board.cut(&bit(tip, degrees), &from, &to).unwrap();
        let expected = (tip + 2.0 * depth * libm::tan(0.5 * degrees.to_radians())) * MM;
        let got = width(&board, 15.0);
        assert!((got - expected).abs() <= 1.001 * CELL_M, "{got} {expected}");
        // half a cell beside the middle, the wall has risen by that over the tangent
        let wall = if tip > 0.0 {
            0.0
        } else {
            0.5 * CELL_M / libm::tan(0.5 * degrees.to_radians())
        };
        assert!((at(&board, 15.0, 10.0) + depth * MM - wall).abs() < 1e-8);
    }
}

#[test]
fn lines_of_a_ball_leave_scallops_of_the_known_height() {
    let mut board = board(20.0, 20.0);
    let (radius, pitch, depth) = (3.0, 1.0, 1.0);
    for line in 0..8 {
        let y = 6.05 + pitch * f64::from(line);
        let (from, to) = (upright([-10.0, y, -depth]), upright([30.0, y, -depth]));
        board.cut(&ball(2.0 * radius), &from, &to).unwrap();
    }
    // h = R − √(R² − (p/2)²): 42 µm; the centres of cells lie on the ridges and in the valleys
    let scallop = radius - libm::sqrt(radius * radius - 0.25 * pitch * pitch);
    let (ridge, valley) = (at(&board, 10.0, 9.56), at(&board, 10.0, 9.06));
    assert!((valley + depth * MM).abs() < 1e-8, "{valley}");
    assert!(
        (ridge - valley - scallop * MM).abs() < 1e-8,
        "{}",
        ridge - valley
    );
}

#[test]
fn a_move_above_or_beside_the_board_changes_nothing() {
    let fresh = board(20.0, 20.0);
    for tool in [flat(6.0), ball(6.0), bit(0.1, 60.0)] {
        for (from, to) in [
            (upright([0.0, 0.0, 0.0]), upright([20.0, 20.0, 0.0])),
            (upright([0.0, 0.0, 1.0]), upright([20.0, 20.0, 80.0])),
            (upright([-30.0, 0.0, -5.0]), upright([-30.0, 90.0, -5.0])),
            (
                pose([0.0, 0.0, 2.0], 20.0, 0.0),
                pose([20.0, 0.0, 2.0], 20.0, 0.0),
            ),
            // on its side, far above
            (
                pose([0.0, 0.0, 900.0], 90.0, 0.0),
                pose([20.0, 0.0, 900.0], 180.0, 0.0),
            ),
        ] {
            let mut board = fresh.clone();
            let cut = board.cut(&tool, &from, &to).unwrap();
            assert_eq!((cut.removed_m3, cut.depth_m), (0.0, 0.0));
            assert_eq!((cut.through, cut.collision), (None, None));
            assert_eq!(board.digest(), fresh.digest());
        }
    }
}

#[test]
fn only_what_is_on_the_board_is_cut() {
    let mut board = board(10.0, 10.0);
    let cut = board
        .cut(
            &flat(6.0),
            &upright([-40.0, 0.0, -1.0]),
            &upright([60.0, 0.0, -1.0]),
        )
        .unwrap();
    // half of the slot lies beyond the edge; 1 mm as f32 is wrong by at most 6e-8 of it
    assert!((cut.removed_m3 - 10.0 * 3.0 * 1.0 * MM * MM * MM).abs() < 2e-15);
    assert_eq!(cut.cells, 100 * 30);
}

#[test]
fn a_tool_below_the_bottom_is_through_and_takes_no_more_than_the_board() {
    let mut board = Board::new([20.0 * MM, 20.0 * MM], 5.0 * MM, CELL_M).unwrap();
    let cut = board
        .cut(
            &flat(4.0),
            &upright([5.0, 10.0, -5.5]),
            &upright([15.0, 10.0, -5.5]),
        )
        .unwrap();
    let through = cut.through.unwrap();
    assert!((through.overlap_m - 0.5 * MM).abs() < 1e-12);
    assert!((through.at_m[2] + 5.5 * MM).abs() < 1e-12);
    assert!(through.at_m[0] > 2.9 * MM && through.at_m[0] < 17.1 * MM);
    let least = board
        .heights()
        .iter()
        .fold(0.0, |a: f32, b| if *b < a { *b } else { a });
    assert!((f64::from(least) + 5.0 * MM).abs() < 1e-9);
    // exactly the bottom is not through
    let cut = board
        .cut(
            &flat(4.0),
            &upright([5.0, 10.0, -5.0]),
            &upright([15.0, 10.0, -5.0]),
        )
        .unwrap();
    assert_eq!(cut.through, None);
}

#[test]
fn the_shank_may_follow_the_edges_down_but_not_rub_or_be_wider() {
    // as thick as the cutter: a plunge deeper than the edges are long is right
    let mut board = board(40.0, 40.0);
    let plunge = [upright([20.0, 20.0, 3.0]), upright([20.0, 20.0, -15.0])];
    let cut = board.cut(&flat(6.0), &plunge[0], &plunge[1]).unwrap();
    assert_eq!(cut.collision, None);
    // from there sideways, the shank rubs for 3 mm
    let aside = upright([22.0, 20.0, -15.0]);
    let cut = board.cut(&flat(6.0), &plunge[1], &aside).unwrap();
    let collision = cut.collision.unwrap();
    assert!(
        (collision.overlap_m - 3.0 * MM).abs() < 1e-9,
        "{collision:?}"
    );
    // in the crescent between the old place and the new one
    let from = |x: f64| libm::hypot(collision.at_m[0] - x * MM, collision.at_m[1] - 20.0 * MM);
    assert!(
        from(20.0) > 3.0 * MM && from(22.0) < 3.0 * MM,
        "{collision:?}"
    );
    // thicker than the cutter, it is in the board as soon as it is below its top
    let mut board = Board::new([40.0 * MM; 2], 18.0 * MM, CELL_M).unwrap();
    let cut = board
        .cut(&flat(3.0), &plunge[0], &upright([20.0, 20.0, -11.9]))
        .unwrap();
    assert_eq!(cut.collision, None);
    let cut = board
        .cut(&flat(3.0), &plunge[0], &upright([20.0, 20.0, -12.3]))
        .unwrap();
    assert!((cut.collision.unwrap().overlap_m - 0.25 * MM).abs() < 0.1 * MM);
    // and so is a tilted one
    let mut board = Board::new([40.0 * MM; 2], 18.0 * MM, CELL_M).unwrap();
    let deep = pose([20.0, 20.0, -16.0], 10.0, 0.0);
    let cut = board.cut(&flat(3.0), &deep, &deep).unwrap();
    assert!(cut.collision.unwrap().overlap_m > 3.0 * MM);
    let shallow = pose([20.0, 20.0, -8.0], 10.0, 0.0);
    assert_eq!(
        board.cut(&flat(3.0), &shallow, &shallow).unwrap().collision,
        None
    );
}

#[test]
fn poses_that_are_none_are_refused_and_change_nothing() {
    let mut board = board(20.0, 20.0);
    let before = board.digest();
    let good = upright([5.0, 5.0, -1.0]);
    let with = |change: fn(&mut Pose)| {
        let mut pose = good;
        change(&mut pose);
        pose
    };
    for (wrong, error) in [
        (with(|p| p.position.x = f64::NAN), CutError::NotFinite),
        (
            with(|p| p.position.z = f64::NEG_INFINITY),
            CutError::NotFinite,
        ),
        (with(|p| p.rotation.m23 = f64::NAN), CutError::NotFinite),
        (with(|p| p.position.y = 10.1), CutError::TooFar),
        (with(|p| p.rotation *= 1.1), CutError::NotARotation),
        (pose([5.0, 5.0, -1.0], 61.0, 0.0), CutError::Tilt),
        // the tip points at the sky
        (pose([5.0, 5.0, -1.0], 180.0, 0.0), CutError::Tilt),
    ] {
        for (from, to) in [(&good, &wrong), (&wrong, &good)] {
            assert_eq!(board.cut(&flat(6.0), from, to).unwrap_err(), error);
        }
    }
    assert_eq!(board.digest(), before);
}

#[test]
fn boards_and_tools_that_cannot_be_are_refused() {
    let size = |x: f64, y: f64, cell: f64| Board::new([x, y], 0.02, cell).unwrap_err();
    for (x, y) in [
        (0.0, 0.1),
        (0.1, -1.0),
        (f64::NAN, 0.1),
        (f64::INFINITY, 0.1),
        (0.6, 0.6),
    ] {
        assert!(
            matches!(size(x, y, CELL_M), BoardError::Size { .. }),
            "{x} {y}"
        );
    }
    assert!(matches!(
        size(1e300, 1e300, CELL_M),
        BoardError::Size { .. }
    ));
    for cell in [0.0, 1e-6, 0.2, f64::NAN] {
        assert!(matches!(size(0.1, 0.1, cell), BoardError::Cell(_)));
    }
    for thickness in [0.0, -1.0, 2.0, f64::NAN] {
        let error = Board::new([0.1, 0.1], thickness, CELL_M).unwrap_err();
        assert!(matches!(error, BoardError::Thickness(_)));
    }
    for wrong in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        for cutter in [
            Cutter::Flat { diameter_m: wrong },
            Cutter::Ball { diameter_m: wrong },
            Cutter::V {
                tip_m: 0.0,
                angle_rad: wrong,
            },
        ] {
            assert!(Tool::new(cutter, shank()).is_err(), "{cutter:?}");
        }
        let cutter = Cutter::Flat { diameter_m: 3e-3 };
        for part in 0..4 {
            let mut shank = shank();
            let parts = [
                &mut shank.cutting_length_m,
                &mut shank.diameter_m,
                &mut shank.stick_out_m,
                &mut shank.holder_diameter_m,
            ];
            *parts.into_iter().nth(part).unwrap() = wrong;
            assert!(Tool::new(cutter, shank).is_err(), "{shank:?}");
        }
    }
    let v = Cutter::V {
        tip_m: -1e-4,
        angle_rad: 1.0,
    };
    assert!(matches!(
        Tool::new(v, shank()),
        Err(ToolError::Length { .. })
    ));
    let big = Cutter::Ball { diameter_m: 26e-3 };
    assert!(matches!(
        Tool::new(big, shank()),
        Err(ToolError::ShortBall { .. })
    ));
    let low = Shank {
        stick_out_m: 10e-3,
        ..shank()
    };
    let error = Tool::new(Cutter::Flat { diameter_m: 3e-3 }, low).unwrap_err();
    assert!(matches!(error, ToolError::StickOut { .. }));
}

#[test]
fn the_greatest_boards_are_made_and_the_digest_tells_shapes_apart() {
    assert_eq!(MAX_CELLS * size_of::<f32>(), 128 << 20);
    let wide = Board::new([0.2, 0.1], 0.02, 0.01).unwrap();
    let tall = Board::new([0.1, 0.2], 0.02, 0.01).unwrap();
    assert_eq!(wide.heights(), tall.heights());
    assert_ne!(wide.digest(), tall.digest());
    assert_eq!(wide.size_m(), [0.2, 0.1]);
}

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
        const POSES: u32 = 4000;
        for (index, got) in board.heights().iter().enumerate() {
            let x = ((index % board.columns()) as f64 + 0.5) * cell;
            let y = ((index / board.columns()) as f64 + 0.5) * cell;
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
                prop_assert!(a == b || (a - b).abs() < 4e-8, "{a} {b}");
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

#[test]
fn a_leaning_flat_mill_cuts_with_its_edge() {
    let mut board = board(30.0, 30.0);
    let tilt = 10.0_f64;
    let stand = pose([15.0, 15.0, 0.0], 0.0, tilt);
    let cut = board.cut(&flat(6.0), &stand, &stand).unwrap();
    // the lower edge of the disc of radius 3 mm is 3·sin 10° below its middle; a cell from it, by tan 10° less
    let deepest = 3.0 * libm::sin(tilt.to_radians()) * MM;
    let missed = CELL_M * libm::tan(tilt.to_radians());
    assert!(cut.depth_m <= deepest + 1e-9 && cut.depth_m >= deepest - missed);
    // a plane: half the disc is below the top. V = ∫ over it of depth = (2/3)·R³·tan, seen from above cos·…
    let volume = 2.0 / 3.0 * 27.0 * libm::sin(tilt.to_radians()) * libm::cos(tilt.to_radians());
    let got = cut.removed_m3 / (MM * MM * MM);
    // and the wall of the cylinder beside it takes a little more
    assert!(got > 0.98 * volume && got < 1.06 * volume, "{got} {volume}");
}
