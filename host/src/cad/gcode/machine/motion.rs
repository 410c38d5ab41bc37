//! What moves: the motion of a line, by the mode that holds.

use super::{
    Block, Cursor, DataError, FARTHEST_M, FASTEST, Machine, Motion, Open, Problem, Target, curve,
    out_of_range, tenths, whole,
};
use crate::cad::step::{Move, Shape, Speed, Step, What, get, set};

impl Machine {
    /// The motion of the line, if it has axes or what else its mode moves by.
    pub(super) fn moves(
        &mut self,
        block: &mut Block<'_>,
        line: u32,
        out: &mut impl FnMut(Step),
    ) -> Result<(), DataError> {
        let axes = *b"xyz";
        let moves = axes.iter().any(|letter| block.has(*letter));
        let starts = block.g().iter().any(|(code, _)| *code == 52);
        let turns = matches!(self.motion, Motion::Arc { .. })
            && b"ijk".iter().any(|letter| block.has(*letter));
        let first_weight = self.motion == Motion::Nurbs && starts;
        if !(moves || turns || first_weight) {
            return Ok(());
        }
        if self.motion == Motion::None {
            let cursor = axes.iter().find_map(|letter| block.value(*letter));
            let (_, cursor) = cursor.unwrap_or((0.0, Cursor::new("", line)));
            return Err(cursor.wrong("axes without a motion", "G0, G1, G2, G3 or G5 before them"));
        }
        let (to, place) = self.target(block)?;
        let place = place.unwrap_or_else(|| {
            let code = block.g().first().copied();
            code.map_or_else(|| Cursor::new("", line), |(_, cursor)| cursor)
        });
        self.use_offset(&place)?;
        let smooth = self.smooth.take();
        if self.motion == Motion::Rapid {
            self.rapid(to, line, out);
            return Ok(());
        }
        let (Some(from_m), Some(to_m)) = (whole_point(&self.at), whole_point(&to)) else {
            return Err(place.error(
                Problem::Missing,
                "a cut from where the program has not said",
                "G0 to a place with X, Y and Z before it",
                format!("no {}", missing(&self.at)),
            ));
        };
        if self.motion == Motion::Nurbs {
            return self.control(block, from_m, to_m, moves, &place);
        }
        let shape = match self.motion {
            Motion::Arc { clockwise } => {
                let modes = curve::Modes {
                    unit_m: self.unit_m,
                    plane: self.plane,
                    absolute: self.absolute_centre,
                };
                curve::arc(block, &modes, clockwise, &from_m, &to_m, &place)?
            }
            Motion::Cubic => {
                self.in_xy(&place)?;
                let (shape, next) =
                    curve::cubic(block, self.unit_m, smooth, &from_m, &to_m, &place)?;
                self.smooth = Some(next);
                shape
            }
            Motion::Quadratic => {
                self.in_xy(&place)?;
                curve::quadratic(block, self.unit_m, &from_m, &to_m, &place)?
            }
            _ => Shape::Line,
        };
        self.at = to;
        let mut made = Move {
            from_m,
            to_m,
            shape,
            speed: Speed::Rapid,
            keeping: self.keeping,
        };
        made.speed = self.cutting(&made, &place)?;
        out(Step {
            line,
            what: What::Move(made),
        });
        Ok(())
    }

    /// Where the axes of a line lead to, and the first of them.
    fn target<'a>(&self, block: &mut Block<'a>) -> Result<Target<'a>, DataError> {
        let mut to = self.at;
        let mut place = None;
        for (k, letter) in b"xyz".iter().copied().enumerate() {
            let Some((value, cursor)) = block.value(letter) else {
                continue;
            };
            place.get_or_insert(cursor);
            let mut value = value * self.unit_m;
            let known = self.at.get(k).copied().flatten();
            if !self.absolute {
                let Some(from) = known else {
                    let what = "an incremental axis before the program has said where it is";
                    return Err(cursor.wrong(what, "G90 and a place of this axis"));
                };
                value += from;
            }
            if !(-FARTHEST_M..=FARTHEST_M).contains(&value) {
                return Err(out_of_range(&cursor, "a coordinate", "within 10 km", value));
            }
            if let Some(axis) = to.get_mut(k) {
                *axis = Some(value);
            }
        }
        Ok((to, place))
    }

    /// Without a place of some axis the tool stays where it is, and gets there with the next motion.
    fn rapid(&mut self, to: [Option<f64>; 3], line: u32, out: &mut impl FnMut(Step)) {
        let from_m = whole_point(&self.at);
        self.at = to;
        if let Some(to_m) = whole_point(&to) {
            out(Step {
                line,
                what: What::Move(Move {
                    from_m: from_m.unwrap_or(to_m),
                    to_m,
                    shape: Shape::Line,
                    speed: Speed::Rapid,
                    keeping: self.keeping,
                }),
            });
        }
    }

    fn in_xy(&self, place: &Cursor<'_>) -> Result<(), DataError> {
        if self.plane == [0, 1, 2] {
            Ok(())
        } else {
            Err(place.wrong("a spline in another plane", "G17 before G5"))
        }
    }

    /// The feed of a cut.
    fn cutting(&self, made: &Move, place: &Cursor<'_>) -> Result<Speed, DataError> {
        let Some(feed) = self.feed else {
            let expected = if self.inverse_time {
                "F in the line, as G93 wants it"
            } else {
                "F before it"
            };
            return Err(place.wrong("a cut without a feed", expected));
        };
        if !self.inverse_time {
            return Ok(Speed::Feed(feed));
        }
        let feed = feed * made.length_m();
        if made.length_m() > 0.0 && !(feed > 0.0 && feed <= FASTEST) {
            let expected = "greater than 0, at most 100 m/s";
            return Err(out_of_range(place, "a feed", expected, feed));
        }
        Ok(Speed::Feed(feed))
    }

    /// One offset in a whole program is as good as another.
    fn use_offset(&mut self, place: &Cursor<'_>) -> Result<(), DataError> {
        let used = *self.offset.get_or_insert(self.chosen_offset);
        if used == self.chosen_offset {
            return Ok(());
        }
        Err(place.error(
            Problem::Conflict,
            "a second work offset: where it is, no file says",
            format!("G{} all the time", tenths(used)),
            format!("G{}", tenths(self.chosen_offset)),
        ))
    }

    /// A control point, G5.2.
    fn control(
        &mut self,
        block: &mut Block<'_>,
        from: [f64; 3],
        to: [f64; 3],
        moves: bool,
        place: &Cursor<'_>,
    ) -> Result<(), DataError> {
        self.in_xy(place)?;
        if get(&from, 2).to_bits() != get(&to, 2).to_bits() {
            return Err(place.wrong("a spline that leaves its plane", "no Z"));
        }
        let weight = block.value(b'p');
        if let Some((weight, cursor)) = weight
            && !(1e-6..=1e6).contains(&weight)
        {
            return Err(out_of_range(&cursor, "a weight", "1e-6 to 1e6", weight));
        }
        let weight = weight.map_or(1.0, |(weight, _)| weight);
        let order = match block.value(b'l') {
            None => None,
            Some((order, cursor)) => {
                let good = whole(order).and_then(|order| usize::try_from(order).ok());
                let good = good.filter(|k| (2..=crate::cad::nurbs::MOST_ORDER).contains(k));
                Some(good.ok_or_else(|| out_of_range(&cursor, "an order", "2 to 12", order))?)
            }
        };
        let line = place.line;
        let first = if moves { 1.0 } else { weight };
        let open = self.open.get_or_insert_with(|| Open {
            line,
            order: None,
            control: vec![(from, first)],
        });
        open.order = order.or(open.order);
        if moves {
            if open.control.len() >= crate::cad::nurbs::MOST_CONTROL {
                return Err(place.wrong("too many control points", "at most 10000"));
            }
            open.control.push((to, weight));
        }
        self.at = to.map(Some);
        Ok(())
    }

    /// G5.3: the spline of the control points.
    pub(super) fn close(
        &mut self,
        block: &Block<'_>,
        line: u32,
        out: &mut impl FnMut(Step),
    ) -> Result<(), DataError> {
        let place = block.g().iter().find(|(code, _)| *code == 53);
        let place = place.map_or_else(|| Cursor::new("", line), |(_, cursor)| *cursor);
        let Some(open) = self.open.take() else {
            return Err(place.wrong("the end of a spline", "G5.2 before G5.3"));
        };
        self.motion = Motion::None;
        let made = curve::nurbs(open.order.unwrap_or(3), open.control, &place)?;
        let mut made = Move {
            keeping: self.keeping,
            ..made
        };
        made.speed = self.cutting(&made, &place)?;
        out(Step {
            line: open.line,
            what: What::Move(made),
        });
        Ok(())
    }
}

fn whole_point(at: &[Option<f64>; 3]) -> Option<[f64; 3]> {
    let mut point = [0.0; 3];
    for (k, axis) in at.iter().enumerate() {
        set(&mut point, k, (*axis)?);
    }
    Some(point)
}

fn missing(at: &[Option<f64>; 3]) -> String {
    let axes = at.iter().zip(["X", "Y", "Z"]);
    let axes = axes
        .filter(|(axis, _)| axis.is_none())
        .map(|(_, name)| name);
    axes.collect::<Vec<_>>().join(", ")
}
