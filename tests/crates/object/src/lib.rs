//! One robot in several forms, each in a module with the same names.
#![deny(unsafe_code, warnings)]

macro_rules! robot {
    ($module:ident: $name:ident, $links:ident, $params:ident, $contacts:ident, $($include:tt)*) => {
        /// The robot in one form.
        pub mod $module {
            $($include)*
            pub use $name as Leg;
            pub use $links as Link;
            pub use $params as Params;
            pub use $contacts as Contacts;
        }
    };
}

robot!(portable: Portable, PortableLink, PortableParams, PortableContacts, modyn::include_model!(portable););
robot!(object: InObject, InObjectLink, InObjectParams, InObjectContacts, modyn::include_model!(in_object););
robot!(copied: InObject, InObjectLink, InObjectParams, InObjectContacts,
    include!(concat!(env!("OUT_DIR"), "/copied.rs")););
robot!(fused: Fused, FusedLink, FusedParams, FusedContacts, modyn::include_model!(fused););
robot!(largest: Largest, LargestLink, LargestParams, LargestContacts, modyn::include_model!(largest););
robot!(single_portable: SinglePortable, SinglePortableLink, SinglePortableParams, SinglePortableContacts,
    modyn::include_model!(single_portable););
robot!(single: Single, SingleLink, SingleParams, SingleContacts, modyn::include_model!(single););
robot!(single_fused: SingleFused, SingleFusedLink, SingleFusedParams, SingleFusedContacts,
    modyn::include_model!(single_fused););
