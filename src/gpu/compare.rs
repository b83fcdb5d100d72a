//! Lock-step comparison of the backends. (under construction)
