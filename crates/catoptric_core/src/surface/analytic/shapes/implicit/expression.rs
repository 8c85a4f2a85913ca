//! Expressions of x, y and z: read once into a short program, evaluated over numbers, dual numbers and intervals.

use crate::math::portable::PortableMath;
use crate::math::scalar::Scalar;
use crate::surface::SurfaceError;

/// The longest text, in bytes.
const MAX_TEXT: usize = 2_000;
/// The most steps of a program.
const MAX_STEPS: usize = 500;
/// The most values that wait at once while a program runs.
pub(super) const MAX_DEPTH: usize = 24;
/// Programs that need no more waiting values run in less memory.
const SMALL_DEPTH: usize = 6;
/// Whole exponents up to this are multiplied out.
const MAX_WHOLE_EXPONENT: f64 = 1024.0;

/// A step of an expression's program in postfix order: pushes a value, or replaces the topmost ones by its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instruction {
    /// Pushes a coordinate of the point: 0 to 2.
    Variable(usize),
    /// Pushes a number.
    Constant(f64),
    /// The sum of two values; the following three take two, too.
    Add,
    /// The second value from the first.
    Subtract,
    /// The product.
    Multiply,
    /// The first value by the second.
    Divide,
    /// The negative of one value; all that follow but [`Self::Power`] take one, too.
    Negate,
    /// A whole power.
    WholePower(i32),
    /// A power of a value that is not negative.
    RealPower(f64),
    /// The first value to the power of the second.
    Power,
    /// The square root.
    Sqrt,
    /// e to this power.
    Exp,
    /// The sine.
    Sin,
    /// The cosine.
    Cos,
    /// The absolute value.
    Abs,
}

const FUNCTIONS: [(&str, Instruction); 5] = [
    ("sqrt", Instruction::Sqrt),
    ("exp", Instruction::Exp),
    ("sin", Instruction::Sin),
    ("cos", Instruction::Cos),
    ("abs", Instruction::Abs),
];

/// A pending operator before its right operand, or an open parenthesis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PendingOperator {
    Operator(Instruction),
    /// A parenthesis, where it stands, and the function of it.
    Parenthesis(usize, Option<Instruction>),
}

/// A program in postfix order.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    steps: Vec<Instruction>,
    depth: usize,
}

/// The precedence of an operator; as in mathematics, `-x^2` is `-(x^2)` and `x^2^3` is `x^(2^3)`.
fn binding(operator: Instruction) -> u32 {
    match operator {
        Instruction::Add | Instruction::Subtract => 1,
        Instruction::Multiply | Instruction::Divide => 2,
        Instruction::Negate => 3,
        _ => 4,
    }
}

fn error_at(position: usize, problem: impl std::fmt::Display) -> SurfaceError {
    SurfaceError { parameter: "expression", problem: format!("character {}: {problem}", position + 1) }
}

impl Expression {
    /// Reads an expression with numbers, `x`, `y`, `z`, `+ - * / ^`, parentheses and the functions `sqrt`, `exp`,
    /// `sin`, `cos` and `abs`. Errors name the character (counted from 1).
    pub fn parse(text: &str) -> Result<Self, SurfaceError> {
        if text.len() > MAX_TEXT {
            return Err(error_at(MAX_TEXT, format!("too long; {MAX_TEXT} bytes are allowed")));
        }
        // The shunting yard (Dijkstra 1961): no recursion, however deep the parentheses.
        let mut reader = Parser { expression: Self { steps: Vec::new(), depth: 0 }, waiting: Vec::new() };
        let bytes = text.as_bytes();
        let mut at = 0;
        let mut wants_operand = true;
        let operand_missing = "expected a number, x, y, z, a function or `(`";
        while at < bytes.len() {
            let begin = at;
            at += 1;
            match bytes[begin] {
                b' ' | b'\t' | b'\r' | b'\n' => {}
                b'0'..=b'9' | b'.' if wants_operand => {
                    at = end_of_number(bytes, begin);
                    let number = text[begin..at].parse::<f64>().ok().filter(|number| number.is_finite());
                    let number =
                        number.ok_or_else(|| error_at(begin, format!("`{}` is no number", &text[begin..at])))?;
                    reader.emit(Instruction::Constant(number), begin)?;
                    wants_operand = false;
                }
                b'a'..=b'z' | b'A'..=b'Z' | b'_' if wants_operand => {
                    while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_') {
                        at += 1;
                    }
                    let name = &text[begin..at];
                    if let Some(axis) = ["x", "y", "z"].iter().position(|variable| *variable == name) {
                        reader.emit(Instruction::Variable(axis), begin)?;
                        wants_operand = false;
                        continue;
                    }
                    let Some((_, function)) = FUNCTIONS.iter().find(|(function, _)| *function == name) else {
                        let known = "known are x, y, z, sqrt, exp, sin, cos and abs";
                        return Err(error_at(begin, format!("unknown name `{name}`; {known}")));
                    };
                    while at < bytes.len() && bytes[at].is_ascii_whitespace() {
                        at += 1;
                    }
                    if bytes.get(at) != Some(&b'(') {
                        return Err(error_at(at, format!("expected `(` after `{name}`")));
                    }
                    reader.waiting.push(PendingOperator::Parenthesis(at, Some(*function)));
                    at += 1;
                }
                b'(' if wants_operand => reader.waiting.push(PendingOperator::Parenthesis(begin, None)),
                b'-' if wants_operand => reader.waiting.push(PendingOperator::Operator(Instruction::Negate)),
                b'+' if wants_operand => {}
                _ if wants_operand => return Err(error_at(begin, operand_missing)),
                b')' => reader.close(begin)?,
                operator => {
                    let operator = match operator {
                        b'+' => Instruction::Add,
                        b'-' => Instruction::Subtract,
                        b'*' => Instruction::Multiply,
                        b'/' => Instruction::Divide,
                        b'^' => Instruction::Power,
                        _ => return Err(error_at(begin, "expected an operator, `)` or the end")),
                    };
                    reader.operator(operator, begin)?;
                    wants_operand = true;
                }
            }
        }
        if wants_operand {
            return Err(error_at(text.len(), operand_missing));
        }
        reader.finish(text.len())
    }

    /// The program.
    pub(super) fn steps(&self) -> &[Instruction] {
        &self.steps
    }

    /// The value at a point.
    #[inline]
    pub fn evaluate<S: Scalar>(&self, point: [S; 3]) -> S {
        if self.depth <= SMALL_DEPTH { self.run::<S, SMALL_DEPTH>(point) } else { self.run::<S, MAX_DEPTH>(point) }
    }

    #[inline]
    fn run<S: Scalar, const DEPTH: usize>(&self, point: [S; 3]) -> S {
        let mut stack = [S::constant(0.0); DEPTH];
        let mut count = 0;
        for step in &self.steps {
            match *step {
                Instruction::Variable(axis) => {
                    stack[count] = point[axis];
                    count += 1;
                }
                Instruction::Constant(value) => {
                    stack[count] = S::constant(value);
                    count += 1;
                }
                Instruction::Add
                | Instruction::Subtract
                | Instruction::Multiply
                | Instruction::Divide
                | Instruction::Power => {
                    count -= 1;
                    let (a, b) = (stack[count - 1], stack[count]);
                    stack[count - 1] = binary(*step, a, b);
                }
                _ => stack[count - 1] = unary(*step, stack[count - 1]),
            }
        }
        stack[0]
    }
}

#[inline]
fn binary<S: Scalar>(step: Instruction, a: S, b: S) -> S {
    match step {
        Instruction::Add => a + b,
        Instruction::Subtract => a - b,
        Instruction::Multiply => a * b,
        Instruction::Divide => a / b,
        _ => (b * a.ln()).exp(),
    }
}

#[inline]
fn unary<S: Scalar>(step: Instruction, a: S) -> S {
    match step {
        Instruction::Negate => -a,
        Instruction::WholePower(exponent) => a.powi(exponent),
        Instruction::RealPower(exponent) => a.powf(exponent),
        Instruction::Sqrt => a.sqrt(),
        Instruction::Exp => a.exp(),
        Instruction::Sin => a.sin(),
        Instruction::Cos => a.cos(),
        _ => a.abs(),
    }
}

/// The end of a number that begins at a byte: digits with a point and an exponent.
fn end_of_number(bytes: &[u8], begin: usize) -> usize {
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.') {
            at += 1;
        }
        at
    };
    let end = digits(begin);
    if !matches!(bytes.get(end), Some(b'e' | b'E')) {
        return end;
    }
    let exponent = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
    if bytes.get(exponent).is_some_and(u8::is_ascii_digit) { digits(exponent) } else { end }
}

struct Parser {
    expression: Expression,
    waiting: Vec<PendingOperator>,
}

impl Parser {
    /// Appends a step; constants are worked out at once.
    fn emit(&mut self, step: Instruction, position: usize) -> Result<(), SurfaceError> {
        let steps = &mut self.expression.steps;
        let step = match (step, steps.as_slice()) {
            (Instruction::Variable(_) | Instruction::Constant(_), _) => step,
            (Instruction::Power, [.., Instruction::Constant(base), Instruction::Constant(exponent)]) => {
                let value = base.power(*exponent);
                steps.truncate(steps.len() - 2);
                constant(value, position)?
            }
            (Instruction::Power, [.., Instruction::Constant(exponent)]) => {
                let exponent = *exponent;
                steps.pop();
                if exponent.fract() == 0.0 && exponent.abs() <= MAX_WHOLE_EXPONENT {
                    Instruction::WholePower(exponent as i32)
                } else {
                    Instruction::RealPower(exponent)
                }
            }
            (
                Instruction::Add | Instruction::Subtract | Instruction::Multiply | Instruction::Divide,
                [.., Instruction::Constant(a), Instruction::Constant(b)],
            ) => {
                let value = binary(step, *a, *b);
                steps.truncate(steps.len() - 2);
                constant(value, position)?
            }
            (
                Instruction::Add
                | Instruction::Subtract
                | Instruction::Multiply
                | Instruction::Divide
                | Instruction::Power,
                _,
            ) => step,
            (_, [.., Instruction::Constant(a)]) => {
                let value = unary(step, *a);
                steps.pop();
                constant(value, position)?
            }
            _ => step,
        };
        if steps.len() >= MAX_STEPS {
            return Err(error_at(position, format!("too many operations; {MAX_STEPS} are allowed")));
        }
        steps.push(step);
        Ok(())
    }

    /// An infix operator: operators before it of higher precedence are applied first.
    fn operator(&mut self, operator: Instruction, position: usize) -> Result<(), SurfaceError> {
        while let Some(PendingOperator::Operator(before)) = self.waiting.last().copied() {
            let is_first = binding(before) > binding(operator)
                || binding(before) == binding(operator) && operator != Instruction::Power;
            if !is_first {
                break;
            }
            self.waiting.pop();
            self.emit(before, position)?;
        }
        self.waiting.push(PendingOperator::Operator(operator));
        Ok(())
    }

    fn close(&mut self, position: usize) -> Result<(), SurfaceError> {
        loop {
            match self.waiting.pop() {
                Some(PendingOperator::Operator(operator)) => self.emit(operator, position)?,
                Some(PendingOperator::Parenthesis(_, function)) => {
                    return function.map_or(Ok(()), |function| self.emit(function, position));
                }
                None => return Err(error_at(position, "`)` without `(`")),
            }
        }
    }

    fn finish(mut self, end: usize) -> Result<Expression, SurfaceError> {
        while let Some(waiting) = self.waiting.pop() {
            match waiting {
                PendingOperator::Operator(operator) => self.emit(operator, end)?,
                PendingOperator::Parenthesis(position, _) => return Err(error_at(position, "`(` without `)`")),
            }
        }
        let mut count = 0usize;
        for step in &self.expression.steps {
            match step {
                Instruction::Variable(_) | Instruction::Constant(_) => count += 1,
                Instruction::Add
                | Instruction::Subtract
                | Instruction::Multiply
                | Instruction::Divide
                | Instruction::Power => count -= 1,
                _ => {}
            }
            self.expression.depth = self.expression.depth.max(count);
        }
        if self.expression.depth > MAX_DEPTH {
            let problem = format!("too deep; {MAX_DEPTH} values may wait for their operators at once");
            return Err(error_at(end, problem));
        }
        if !self.expression.steps.iter().any(|step| matches!(step, Instruction::Variable(_))) {
            return Err(error_at(0, "must depend on x, y or z"));
        }
        Ok(self.expression)
    }
}

/// A constant that was worked out.
fn constant(value: f64, position: usize) -> Result<Instruction, SurfaceError> {
    match value.is_finite() {
        true => Ok(Instruction::Constant(value)),
        false => Err(error_at(position, format!("the constant before it is {value}"))),
    }
}
