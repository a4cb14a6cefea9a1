! The law of Blatz and Ko as an Abaqus VUMAT (compare blatz_ko.f90), from the right stretch U of F = R U:
!
!   W = mu/2 (I2/J^2 + 2 J - 5),   R^T sigma R = mu (1 - U^-2 / J)
!
! props(1) = mu, in units of stress. No state variables. Energies are per mass.
!
!   gfortran -shared -fPIC -O2 -o blatz_ko_vumat.so blatz_ko_vumat.f90
subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, charLength, &
                 props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, stressOld, stateOld, &
                 enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, &
                 enerInelasNew)
  implicit none
  integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
  character(len=80), intent(in) :: cmname
  double precision, intent(in) :: stepTime, totalTime, dt, coordMp(nblock, *), charLength(nblock), props(nprops)
  double precision, intent(in) :: density(nblock), strainInc(nblock, ndir + nshr), relSpinInc(nblock, nshr), tempOld(nblock)
  double precision, intent(in) :: stretchOld(nblock, ndir + nshr), defgradOld(nblock, ndir + 2*nshr), fieldOld(nblock, nfieldv)
  double precision, intent(in) :: stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), enerInternOld(nblock)
  double precision, intent(in) :: enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, ndir + nshr)
  double precision, intent(in) :: defgradNew(nblock, ndir + 2*nshr), fieldNew(nblock, nfieldv)
  double precision, intent(out) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), enerInternNew(nblock)
  double precision, intent(out) :: enerInelasNew(nblock)
  double precision :: mu, u(3, 3), inverse(3, 3), b(3, 3), jacobian, mass
  integer :: k, r, c

  mu = props(1)
  do k = 1, nblock
    u(1, :) = [stretchNew(k, 1), stretchNew(k, 4), stretchNew(k, 6)]
    u(2, :) = [stretchNew(k, 4), stretchNew(k, 2), stretchNew(k, 5)]
    u(3, :) = [stretchNew(k, 6), stretchNew(k, 5), stretchNew(k, 3)]
    do c = 1, 3
      do r = 1, 3
        inverse(r, c) = u(next(c), next(r))*u(next(next(c)), next(next(r))) - u(next(c), next(next(r)))*u(next(next(c)), next(r))
      end do
    end do
    jacobian = dot_product(u(1, :), inverse(:, 1))
    inverse = inverse/jacobian
    b = matmul(inverse, inverse)
    stressNew(k, 1:3) = mu*(1.0d0 - [b(1, 1), b(2, 2), b(3, 3)]/jacobian)
    stressNew(k, 4:6) = -mu*[b(1, 2), b(2, 3), b(3, 1)]/jacobian
    stateNew(k, :) = stateOld(k, :)
    ! The mass per reference volume, from the density in the middle of the increment.
    mass = density(k)*0.5d0*(jacobian + volume(defgradOld(k, :)))
    enerInternNew(k) = 0.5d0*mu*(b(1, 1) + b(2, 2) + b(3, 3) + 2.0d0*jacobian - 5.0d0)/mass
    enerInelasNew(k) = enerInelasOld(k)
  end do

contains

  pure integer function next(n)
    integer, intent(in) :: n
    next = modulo(n, 3) + 1
  end function next

  ! det F; the order of the components is 11, 22, 33, 12, 23, 31, 21, 32, 13.
  pure double precision function volume(f)
    double precision, intent(in) :: f(9)
    volume = f(1)*(f(2)*f(3) - f(5)*f(8)) - f(4)*(f(7)*f(3) - f(5)*f(6)) + f(9)*(f(7)*f(8) - f(2)*f(6))
  end function volume
end subroutine vumat
