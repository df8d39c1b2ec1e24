//! The functions of the trait of robots, from the table of quantities.

/// Declares the functions of the trait.
macro_rules! declare_functions {
    ($(
        $function:ident $name:ident $(/ $with:ident)? ($($argument:ident),* $(; $link:ident)?)
        -> $result:ident $(as $named:literal)?, [$($flag:ident)*], $docs:literal, $message:literal
        $(, batch $batch:ident $batch_message:literal)?
        => |$robot:ident, [$($out:ident),*]| $body:expr;
    )*) => {
        $(
            declare_function! {
                $docs $function $name $(/ $with)?
                ($($argument: argument_type!($argument),)* $($link: Self::Link,)?) -> result_type!($result)
            }
        )*
    };
}

/// Declares a function of the trait, which requires the trait of robots that have it. A row with
/// two names is two functions, one with run-time parameters and one with the default parameters.
macro_rules! declare_function {
    (
        $docs:literal $function:ident $name:ident / $with:ident
        ($($argument:ident: $of:ty,)*) -> $result:ty
    ) => {
        #[doc = $docs]
        #[allow(clippy::too_many_arguments)]
        fn $with<T: Scalar>(params: &Self::Params<T>, $($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            missing!(params, $($argument),*)
        }

        #[doc = concat!(
            "Calls [`", stringify!($with), "`](Self::", stringify!($with),
            ") with the default parameters.",
        )]
        #[allow(clippy::too_many_arguments)]
        fn $name<T: Scalar>($($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            Self::$with(&Self::Params::<T>::default(), $($argument),*)
        }
    };
    (
        $docs:literal $function:ident $name:ident
        ($($argument:ident: $of:ty,)*) -> $result:ty
    ) => {
        #[doc = $docs]
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
