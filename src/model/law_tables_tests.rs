use super::*;
use crate::case;

fn cell(set: &str) -> UnitCellParameters<f64> {
    UnitCellParameters::new(&case::shipped(&[set]).fabric)
}

#[test]
fn models_share_the_table_of_their_cell_and_no_other() {
    let law = Law::Published;
    for set in ["/fabric/warp/crimp=0.02", "/fabric/warp/crimp=0.021", "/fabric/weft/modulus_gpa=90"] {
        let cell = cell(set);
        let [first, again] = [law_energy(law, &cell), law_energy(law, &cell)];
        assert!(first.as_ref().zip(again.as_ref()).is_some_and(|(first, again)| Arc::ptr_eq(first, again)), "{set}");
        assert_eq!(first.as_deref(), LawEnergy::new(law, &cell).as_ref(), "{set}");
    }
    assert!(law_energy(Law::Variational, &cell("/fabric/warp/crimp=0.02")).is_none());
}
