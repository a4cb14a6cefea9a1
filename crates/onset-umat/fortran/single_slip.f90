! A crystal with one slip system as an Abaqus UMAT: finite strains, rate-independent, Schmid's law, linear hardening.
!
! F = Fe (1 + gamma s (x) m), slip direction s and slip plane normal m of the undeformed lattice. Neo-Hookean elasticity of Fe,
! tau = G (be - 1) + lambda ln J 1, so that the resolved shear stress (s*.tau m*, s* = Fe s, m* = Fe^-T m) is G (s.C m - gamma s.C s)
! with C = F^T F: Schmid's law, resolved = +-(strength + h |gamma|), is linear in the slip, and no increment errs. Slip goes on in one sense.
!
! PROPS: shear modulus G, Lame's first constant, strength, hardening modulus h, angle of s from axis 1 in the plane of 1 and 2 in degrees.
! STATEV(1): slip gamma.
!
! With the Jaumann rate of tau for D: M of elasticity, B = M:P + Omega tau - tau Omega for slip, P + Omega = s* (x) m*,
! DDSDDE = (M - B (x) B/(h + B:P))/J
! (R. Hill and J. R. Rice, J. Mech. Phys. Solids 20 (1972) 401). A velocity gradient s* (x) m* is slip alone, so that with h = 0 bands along
! the slip plane meet no resistance (R. J. Asaro and J. R. Rice, J. Mech. Phys. Solids 25 (1977) 309).
!
!   gfortran -shared -fPIC -O2 -o single_slip.so single_slip.f90
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
  integer, parameter :: first(6) = [1, 2, 3, 1, 1, 2], second(6) = [1, 2, 3, 2, 3, 3]
  double precision :: shear, lame, strength, hardening, angle, volume, slip, trial, excess
  double precision :: s(3), m(3), fs(3), fm(3), elastic(3, 3), left(3, 3), tau(3, 3), one(3, 3)
  double precision :: p(3, 3), omega(3, 3), b(3, 3), moduli(6, 6)
  integer :: i, j, k, l, a, c

  shear = props(1)
  lame = props(2)
  strength = props(3)
  hardening = props(4)
  angle = props(5)*acos(-1.0d0)/180.0d0
  s = [cos(angle), sin(angle), 0.0d0]
  m = [-sin(angle), cos(angle), 0.0d0]
  one = 0.0d0
  do i = 1, 3
    one(i, i) = 1.0d0
  end do

  ! Schmid's law.
  fs = matmul(dfgrd1, s)
  fm = matmul(dfgrd1, m)
  trial = shear*dot_product(fs, fm)
  excess = abs(trial) - strength
  slip = 0.0d0
  if (excess > 0.0d0) slip = sign(excess/(shear*dot_product(fs, fs) + hardening), trial)
  statev(1) = slip

  elastic = dfgrd1
  do j = 1, 3
    elastic(:, j) = elastic(:, j) - slip*fs*m(j)
  end do
  volume = dot_product(dfgrd1(:, 1), cross(dfgrd1(:, 2), dfgrd1(:, 3)))
  left = matmul(elastic, transpose(elastic))
  tau = shear*(left - one) + lame*log(volume)*one

  ! Elasticity, for the Jaumann rate of tau.
  do c = 1, 6
    k = first(c)
    l = second(c)
    do a = 1, 6
      i = first(a)
      j = second(a)
      moduli(a, c) = lame*one(i, j)*one(k, l) + (shear - lame*log(volume))*(one(i, k)*one(j, l) + one(i, l)*one(j, k)) &
                     + 0.5d0*(one(i, k)*tau(j, l) + one(i, l)*tau(j, k) + tau(i, k)*one(j, l) + tau(i, l)*one(j, k))
    end do
  end do

  if (excess > 0.0d0) then
    ! m* = Fe^-T m, by the cofactor of Fe, whose determinant equals det F.
    fm = cofactor_times(elastic, m)/volume
    do j = 1, 3
      do i = 1, 3
        p(i, j) = 0.5d0*(fs(i)*fm(j) + fs(j)*fm(i))
        omega(i, j) = 0.5d0*(fs(i)*fm(j) - fs(j)*fm(i))
      end do
    end do
    b = matmul(omega, tau) - matmul(tau, omega)
    do a = 1, 6
      i = first(a)
      j = second(a)
      do c = 1, 6
        ! Shears count twice in a sum over six.
        b(i, j) = b(i, j) + moduli(a, c)*p(first(c), second(c))*merge(1.0d0, 2.0d0, c <= 3)
      end do
      b(j, i) = b(i, j)
    end do
    do c = 1, 6
      do a = 1, 6
        moduli(a, c) = moduli(a, c) - b(first(a), second(a))*b(first(c), second(c))/(hardening + sum(b*p))
      end do
    end do
  end if

  ddsdde = moduli/volume
  do a = 1, 6
    stress(a) = tau(first(a), second(a))/volume
  end do
  sse = (0.5d0*shear*(left(1, 1) + left(2, 2) + left(3, 3) - 3.0d0 - 2.0d0*log(volume)) + 0.5d0*lame*log(volume)**2)/volume
  spd = (strength + 0.5d0*hardening*abs(slip))*abs(slip)/volume

contains

  function cofactor_times(f, n) result(turned)
    double precision, intent(in) :: f(3, 3), n(3)
    double precision :: turned(3)

    turned = n(1)*cross(f(:, 2), f(:, 3)) + n(2)*cross(f(:, 3), f(:, 1)) + n(3)*cross(f(:, 1), f(:, 2))
  end function cofactor_times

  function cross(u, v) result(product)
    double precision, intent(in) :: u(3), v(3)
    double precision :: product(3)

    product = [u(2)*v(3) - u(3)*v(2), u(3)*v(1) - u(1)*v(3), u(1)*v(2) - u(2)*v(1)]
  end function cross
end subroutine umat
