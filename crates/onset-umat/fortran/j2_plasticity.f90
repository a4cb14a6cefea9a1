! Plasticity of von Mises with linear isotropic hardening as an Abaqus UMAT: small strains in the frame that turns with the
! material. Abaqus rotates the stress by DROT before the call, so the increment is as in the small-strain theory, with the
! logarithmic strain increment in place of the small strain increment.
!
! PROPS: Young's modulus, Poisson's ratio, yield stress, hardening modulus d(yield stress)/d(equivalent plastic strain).
! STATEV(1): equivalent plastic strain.
!
! Radial return: the trial stress s_trial leaves the yield surface by f = q_trial - y(p). The plastic increment solves
! q_trial - 3 G dp = y(p) + H dp, and the deviator shrinks by 1 - 3 G dp / q_trial. The tangent is that of the algorithm
! (Simo and Taylor, Comput. Methods Appl. Mech. Eng. 48 (1985) 101).
!
!   gfortran -shared -fPIC -O2 -o j2_plasticity.so j2_plasticity.f90
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
  double precision :: shear, bulk, hardening, yield, pressure, trial, increment, shrink, ratio
  double precision :: deviator(6), flow(6), elastic(6, 6), old(6), work
  integer :: i, j

  shear = props(1)/(2.0d0*(1.0d0 + props(2)))
  bulk = props(1)/(3.0d0*(1.0d0 - 2.0d0*props(2)))
  hardening = props(4)
  elastic = 0.0d0
  elastic(1:3, 1:3) = bulk - 2.0d0*shear/3.0d0
  do i = 1, 3
    elastic(i, i) = elastic(i, i) + 2.0d0*shear
    elastic(i + 3, i + 3) = shear
  end do

  old = stress
  stress = stress + matmul(elastic, dstran)
  pressure = sum(stress(1:3))/3.0d0
  deviator = stress
  deviator(1:3) = deviator(1:3) - pressure
  trial = sqrt(1.5d0*(sum(deviator(1:3)**2) + 2.0d0*sum(deviator(4:6)**2)))
  yield = props(3) + hardening*statev(1)
  ddsdde = elastic
  increment = 0.0d0

  if (trial > yield) then
    increment = (trial - yield)/(3.0d0*shear + hardening)
    shrink = 1.0d0 - 3.0d0*shear*increment/trial
    flow = 1.5d0*deviator/trial
    stress = shrink*deviator
    stress(1:3) = stress(1:3) + pressure
    statev(1) = statev(1) + increment
    ! bulk part + shrunk deviatoric part - what the flow takes away.
    ddsdde = 0.0d0
    ddsdde(1:3, 1:3) = bulk - 2.0d0*shear*shrink/3.0d0
    do i = 1, 3
      ddsdde(i, i) = ddsdde(i, i) + 2.0d0*shear*shrink
      ddsdde(i + 3, i + 3) = shear*shrink
    end do
    ratio = 4.0d0*shear**2*(1.0d0/(3.0d0*shear + hardening) - increment/trial)
    do j = 1, 6
      do i = 1, 6
        ddsdde(i, j) = ddsdde(i, j) - ratio*flow(i)*flow(j)
      end do
    end do
  end if

  work = 0.5d0*dot_product(old + stress, dstran)
  spd = spd + increment*(props(3) + hardening*(statev(1) - 0.5d0*increment))
  sse = sse + work - increment*(props(3) + hardening*(statev(1) - 0.5d0*increment))
end subroutine umat
