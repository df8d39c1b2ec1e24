//! The functions of the trait of robots, from the table of functions.

/// Declares the functions of the trait.
macro_rules! declare_functions {
    ($($group:ident { $(
        $(#[$documentation:meta])*
        $name:ident $(/ $with:ident)? ($($arguments:tt)*) -> $result:ty,
            if $function:ident, else $message:literal;
    )* })*) => {
        $($(
            declare_function! {
                $(#[$documentation])*
                $name $(/ $with)? ($($arguments)*) -> $result, if $function
            }
        )*)*
    };
}

/// Declares a function of the trait, which requires the trait of robots that have it. A row with two names is two
/// functions, one with run-time parameters and one with the default parameters.
macro_rules! declare_function {
    (
        $(#[$documentation:meta])*
        $name:ident / $with:ident($($argument:ident: $of:ty),*) -> $result:ty, if $function:ident
    ) => {
        $(#[$documentation])*
        #[allow(clippy::too_many_arguments)]
        fn $with<T: Scalar>(params: &Self::Params<T>, $($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            missing!(params, $($argument),*)
        }

        #[doc = concat!("Calls [`", stringify!($with), "`](Self::", stringify!($with), ") with the default parameters.")]
        #[allow(clippy::too_many_arguments)]
        fn $name<T: Scalar>($($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            Self::$with(&Self::Params::<T>::default(), $($argument),*)
        }
    };
    (
        $(#[$documentation:meta])*
        $name:ident($($argument:ident: $of:ty),*) -> $result:ty, if $function:ident
    ) => {
        $(#[$documentation])*
        fn $name<T: Scalar>($($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            missing!($($argument),*)
        }
    };
}

/// The body of a function that a robot does not have. Its bound prevents calls.
macro_rules! missing {
    ($($argument:ident),*) => {{
        $(let _ = $argument;)*
        const { panic!("a trait of `modyn::functions` is implemented for a robot without that function") }
    }};
}

pub(super) use {declare_function, declare_functions, missing};
