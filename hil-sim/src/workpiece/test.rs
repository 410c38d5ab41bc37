use super::*;
use nalgebra::Vector3;

mod property;

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
    let (column, row) = (whole(x * MM / CELL_M), whole(y * MM / CELL_M));
    f64::from(board.heights()[row * board.columns() + column])
}

/// The number of cells in the column of cells at x (mm) that are lower than −0.1 µm.
fn width(board: &Board, x: f64) -> f64 {
    let column = whole(x * MM / CELL_M);
    let cut = board.heights().iter().skip(column).step_by(board.columns());
    number(cut.filter(|h| **h < -1e-7).count()) * CELL_M
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
    // beyond the first hole, beside the line or round its end
    let [x, y, _] = collision.at_m.map(|v| v / MM - 20.0);
    assert!(
        libm::hypot(x, y) > 3.0 && y.abs() < 3.0 && x > 0.0 && x < 5.0,
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
    assert_eq!((wide.columns(), wide.heights().len()), (20, 200));
    assert!((wide.size_m()[0] - 0.2).abs() < 1e-12 && (wide.size_m()[1] - 0.1).abs() < 1e-12);
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
