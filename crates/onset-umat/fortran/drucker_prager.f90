! Plasticity of Drucker and Prager with a strength that hardens and then softens, as an Abaqus UMAT: small strains in the frame that turns with the material,
! as in j2_plasticity.f90. In the notation of Rudnicki and Rice (J. Mech. Phys. Solids 23 (1975) 371), with tau = sqrt(s:s/2) and the mean stress p:
!
!   f = tau + mu p - k(g) <= 0,   plastic strain rate (s/(2 tau) + beta/3 1) dg,   k(g) = kr + (k0 - kr + h0 g) exp(-g/gr).
!
! PROPS: shear modulus G, bulk modulus K, friction mu, dilatancy beta, k0, kr, h0, gr.
! STATEV(1): plastic shear strain g.
!
! Implicit step: tau = tau_trial - G dg and p = p_trial - K beta dg, with dg from f = 0 by Newton's method. The apex of the cone is not returned to: a step that
! would need it requests a smaller increment. The tangent is the consistent tangent of the step.
!
!   gfortran -shared -fPIC -O2 -o drucker_prager.so drucker_prager.f90
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, &
                predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
                noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  character(len=80), intent(in) :: cmname
  double precision, intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, pnewdt
  double precision, intent(inout) :: ddsddt(ntens), drplde(ntens), drpldt
  double precision, intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*)
  double precision, intent(in) :: props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
  double precision :: shear, bulk, friction, dilatancy, pressure, trial, step, shrink, excess, stiffness, change
  double precision :: deviator(6), unit(6), flow(6), normal(6), one(6)
  integer :: i, j

  shear = props(1)
  bulk = props(2)
  friction = props(3)
  dilatancy = props(4)
  one = (/1.0d0, 1.0d0, 1.0d0, 0.0d0, 0.0d0, 0.0d0/)

  call elastic(1.0d0)
  stress = stress + matmul(ddsdde, dstran)
  pressure = sum(stress(1:3))/3.0d0
  deviator = stress - pressure*one
  trial = sqrt(0.5d0*sum(deviator(1:3)**2) + sum(deviator(4:6)**2))
  if (trial + friction*pressure <= strength(statev(1))) return

  stiffness = shear + friction*dilatancy*bulk
  step = 0.0d0
  do i = 1, 60
    excess = trial + friction*pressure - stiffness*step - strength(statev(1) + step)
    change = excess/(stiffness + modulus(statev(1) + step))
    step = step + change
    if (abs(change) <= 1.0d-15*abs(step)) exit
  end do
  shrink = 1.0d0 - shear*step/trial
  if (.not. (step > 0.0d0 .and. shrink > 0.0d0)) then
    pnewdt = 0.25d0
    return
  end if
  statev(1) = statev(1) + step
  stress = shrink*deviator + (pressure - bulk*dilatancy*step)*one

  unit = deviator/trial
  flow = shear*unit + bulk*dilatancy*one
  normal = shear*unit + bulk*friction*one
  stiffness = stiffness + modulus(statev(1))
  call elastic(shrink)
  do j = 1, 6
    do i = 1, 6
      ddsdde(i, j) = ddsdde(i, j) + shear**2*step/trial*unit(i)*unit(j) - flow(i)*normal(j)/stiffness
    end do
  end do

contains

  ! Isotropic elasticity, with a part of the shear modulus.
  subroutine elastic(part)
    double precision, intent(in) :: part
    integer :: n
    ddsdde = 0.0d0
    ddsdde(1:3, 1:3) = bulk - 2.0d0*part*shear/3.0d0
    do n = 1, 3
      ddsdde(n, n) = ddsdde(n, n) + 2.0d0*part*shear
      ddsdde(n + 3, n + 3) = part*shear
    end do
  end subroutine elastic

  double precision function strength(slip)
    double precision, intent(in) :: slip
    strength = props(6) + (props(5) - props(6) + props(7)*slip)*exp(-slip/props(8))
  end function strength

  double precision function modulus(slip)
    double precision, intent(in) :: slip
    modulus = (props(7) - (props(5) - props(6) + props(7)*slip)/props(8))*exp(-slip/props(8))
  end function modulus

end subroutine umat
