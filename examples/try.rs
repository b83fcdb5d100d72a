use ripstop::case; use ripstop::simulation::*; use std::sync::atomic::AtomicBool;
fn main(){
 let a:Vec<String>=std::env::args().collect();
 let sets:Vec<String>=a[2..].iter().filter(|s|s.starts_with("/")).cloned().collect();
 let c=case::read(std::path::Path::new(&a[1]),&sets).unwrap_or_else(|e|{println!("{e}");std::process::exit(2)});
 let t=std::time::Instant::now();
 let p= if a.iter().any(|x|x=="f32"){Precision::F32}else{Precision::F64};
 let th=a.iter().find_map(|x|x.strip_prefix("t=").map(|y|y.parse().unwrap()));
 let r=run(&c,Options{threads:th,precision:p},&AtomicBool::new(false),&mut |_|{}).unwrap();
 let every = r.history.len()/24+1;
 for (i,s) in r.history.iter().enumerate(){ if i%every==0||i+1==r.history.len(){let b=&s.balance; println!("{:8.2} V {:9.4} d {:8.4} F {:8.1} K {:8.4} I {:8.4} S {:8.4} H {:.5} C {:.4} f {:.4} X {:.4} P {:8.4} err {:.2e} mom {:.1e} fail {:?} er {} defl {:.3} T {:.1}",s.time*1e6,s.projectile_velocity,s.projectile_displacement*1e3,s.contact_force,b.kinetic,b.internal,b.stored,b.hourglass,b.contact,b.friction,b.failure,b.projectile,b.error,b.momentum_error,s.failed,s.eroded,s.deflection*1e3,b.max_tension)}}
 for q in [20.,40.,60.,80.,100.]{ if let Some(s)=r.history.iter().find(|s|s.time>=q*1e-6-1e-9){print!("{}:{:.3} ",q,s.projectile_velocity)}}
 println!("\n{:?} stop {:?} pen {:.4} mm err {:.2e} mom {:.1e} hg {:.4} newton {:?} steps {} dt {:.4} ({}) loop {:.2}s  {:.2} Mes/s, threads {} trouble {:?} total {:?}",r.outcome,r.stop_time,r.max_penetration*1e3,r.energy_error,r.momentum_error,r.hourglass_fraction,r.newton,r.steps,r.time_step*1e6,r.step_set_by,r.loop_seconds,r.elements as f64*r.steps as f64/r.loop_seconds/1e6,r.threads,r.trouble,t.elapsed());
 for p in &r.profiles { println!("profile {:.2}: plateau {:?} kink {:?} front {:?}",p.time*1e6,p.plateau_strain(),p.kink(),p.front()) }
 if r.profiles.len()>1 { let (a,b)=(&r.profiles[0],&r.profiles[r.profiles.len()-1]); println!("kink {:?} front {:?}", ripstop::profile::speed(a,b,|p|p.kink()), ripstop::profile::speed(a,b,|p|p.front())) }
}
