use super::*;

#[test]
fn a_pointer_into_a_fabric_names_its_place() {
    for (pointer, place) in [
        ("/fabric", Some("/fabric")),
        ("/fabric/warp/crimp", Some("/fabric")),
        ("/fabrics", None),
        ("/pack/layup/1", None),
        ("/pack/layup/1/fabric", Some("/pack/layup/1/fabric")),
        ("/pack/layup/12/fabric/shear/g1_mpa", Some("/pack/layup/12/fabric")),
        ("/pack/layup/1/fabrics", None),
        ("/pack/layup/01/fabric", None),
        ("/pack/layup//fabric", None),
    ] {
        assert_eq!(around(pointer), place, "{pointer}");
    }
    assert!(holds_fabrics("/pack/layup") && holds_fabrics("/pack/layup/3"));
    assert!(!holds_fabrics("/pack/layups") && !holds_fabrics("/pack/layup/x") && !holds_fabrics("/pack/layup/3/edges"));
}
