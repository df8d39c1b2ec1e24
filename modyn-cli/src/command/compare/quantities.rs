//! The functions that are compared: the call of the generated code, and their evaluation by the
//! interpreter.

use modyn_codegen::Function;
use modyn_codegen::plan::Argument;
use modyn_runtime::{Interpreter, LinkError, Scalar};

/// The arguments of functions.
pub struct State<S = f64> {
    pub q: Vec<S>,
    pub qd: Vec<S>,
    /// Torques, accelerations or a right-hand side.
    pub u: Vec<S>,
}

impl State {
    /// Returns the state in single precision.
    pub fn rounded(&self) -> State<f32> {
        let [q, qd, u] = [&self.q, &self.qd, &self.u]
            .map(|numbers| numbers.iter().map(|&number| f32::from_f64(number)).collect());
        State { q, qd, u }
    }
}

impl<S> State<S> {
    /// Returns the numbers of an argument of a function, by the argument's name.
    pub fn argument(&self, name: &str) -> &[S] {
        match field(name) {
            "q" => &self.q,
            "qd" => &self.qd,
            _ => &self.u,
        }
    }
}

/// Returns the field of a state that has the numbers of an argument, by the argument's name.
fn field(name: &str) -> &'static str {
    match name {
        "q" => "q",
        "qd" | "v" => "qd",
        _ => "u",
    }
}

/// A function that is compared.
pub struct Quantity {
    pub function: Function,
    /// Whether it divides by the mass matrix.
    pub solves: bool,
    /// The call in Rust, of the type `Robot` at the state `s`.
    pub call: String,
}

impl Quantity {
    /// Returns the numbers of the result by the interpreter.
    ///
    /// # Errors
    ///
    /// If the state does not have the model's length.
    pub fn interpret<S: Scalar + PartialOrd>(
        &self,
        robot: &mut Interpreter<S>,
        state: &State<S>,
    ) -> Result<Vec<S>, LinkError> {
        let row = self.function.row();
        // Factors have another order in generated code, so a solution is compared.
        if self.function == Function::Brge {
            return Ok(robot.brge(&state.q)?.solve(&state.u)?);
        }
        let arguments: Vec<&[S]> =
            row.arguments.iter().map(|argument| state.argument(argument.name)).collect();
        let mut result = vec![S::zero(); (row.result)(&robot.sizes()).len()];
        robot.evaluate(self.function, &arguments, 0, &mut result)?;
        Ok(result)
    }

    /// Returns whether machine code has no result to compare: its factors of the mass matrix solve
    /// nothing by themselves.
    pub fn needs_rustc(&self) -> bool {
        self.function == Function::Brge
    }
}

/// Returns the functions that are compared, in the order of the table: the default functions and
/// the derivatives of inverse and forward dynamics, as far as they have a state alone as arguments.
pub fn quantities() -> impl Iterator<Item = Quantity> {
    let derivatives = [Function::InverseDynamicsDerivatives, Function::ForwardDynamicsDerivatives];
    let is_compared = move |function: &Function| {
        let row = function.row();
        let of_a_state =
            |argument: &Argument| matches!(argument.name, "q" | "qd" | "qdd" | "tau" | "v");
        (row.default || derivatives.contains(function))
            && row.is_general()
            && !row.by_link
            && row.arguments.iter().all(of_a_state)
            && *function != Function::NormalizeConfiguration
    };
    Function::ALL.iter().copied().filter(is_compared).map(|function| {
        let solves = matches!(
            function,
            Function::ForwardDynamics | Function::Brge | Function::ForwardDynamicsDerivatives
        );
        Quantity { function, solves, call: call(function) }
    })
}

/// Returns the call in Rust.
fn call(function: Function) -> String {
    let argument = |argument: &Argument| format!("&s.{}", field(argument.name));
    let arguments: Vec<String> = function.row().arguments.iter().map(argument).collect();
    // Factors have another order in the interpreter, so a solution is compared.
    let then = if function == Function::Brge { ".solve(&s.u)" } else { "" };
    format!("{}({}){then}", function.name(), arguments.join(", "))
}

#[cfg(test)]
mod tests {
    use modyn_codegen::Function;

    use super::{call, quantities};

    #[test]
    fn calls_have_the_arguments_of_the_table() {
        assert_eq!(call(Function::ForwardDynamics), "forward_dynamics(&s.q, &s.qd, &s.u)");
        assert_eq!(call(Function::Integrate), "integrate(&s.q, &s.qd)");
        assert_eq!(call(Function::Brge), "brge(&s.q).solve(&s.u)");
        let default = Function::DEFAULT.iter().filter(|function| function.row().is_general());
        let compared: Vec<Function> = quantities().map(|quantity| quantity.function).collect();
        let left: Vec<&Function> = default.filter(|one| !compared.contains(one)).collect();
        let expected = [
            Function::LinkPose,
            Function::Jacobian,
            Function::Difference,
            Function::NormalizeConfiguration,
            Function::RandomConfiguration,
        ];
        assert_eq!(left, expected.iter().collect::<Vec<_>>());
    }
}
