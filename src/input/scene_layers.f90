!> Materials of the two bodies of a scene, with layers that are bonded to them.
!>
!> `elastic_modulus` and `poisson_ratio` are those of a body; under a layer they are those of its
!> base, and the moduli of the layer are those of the surface.
module asperity_scene_layers
  use asperity_kinds, only: real64
  use asperity_numeral, only: above_zero, not_negative
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_values, only: effect_off, scene
  implicit none
  private

  public :: check_layers, read_bodies

  ! Names of a layer.
  character(len=*), parameter :: names(3) = [character(len=15) :: 'layer_thickness', &
    'layer_modulus', 'layer_poisson']

contains

  !> Reads the moduli of both bodies and their layers.
  subroutine read_bodies(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! a deck has brought its moduli; gets both bodies
    real(real64) :: modulus(2), ratio(2)
    logical :: layered(2)
    integer :: i

    associate (bodies => checked%bodies)
      call fields%take('material', trim(names(1)), bodies%thickness)
      layered = bodies%thickness > 0.0_real64
      modulus = [checked%upper%elastic_modulus, checked%lower%elastic_modulus]
      call fields%take('material', 'elastic_modulus', modulus, &
                       merge(not_negative, above_zero, any(layered)))
      ratio = [checked%upper%poisson_ratio, checked%lower%poisson_ratio]
      call fields%take('material', 'poisson_ratio', ratio)
      do i = 1, 2
        bodies(i)%modulus = modulus(i)
        bodies(i)%ratio = ratio(i)
        if (any(layered) .and. .not. (layered(i) .or. modulus(i) > 0.0_real64) .and. &
            fields%has_name('material', 'elastic_modulus')) &
          call fields%complain_of('material', 'elastic_modulus', 'found 0 of a body without a ' // &
                                  'layer, expected a number more than 0: a rigid base has a layer')
      end do
      call fields%take('material', trim(names(2)), modulus)
      call fields%take('material', trim(names(3)), ratio)
      do i = 1, 2
        if (any(layered)) call fields%require_name('material', trim(names(1 + i)), &
                                                   'that of each layer, upper and lower')
        if (.not. any(layered)) call fields%refuse_name( &
          'material', trim(names(1 + i)), 'found without layer_thickness, expected both')
        if (.not. layered(i)) cycle
        bodies(i)%modulus(1) = modulus(i)
        bodies(i)%ratio(1) = ratio(i)
        if (.not. modulus(i) > 0.0_real64) &
          call fields%complain_of('material', trim(names(2)), 'found 0 of a layer, expected a ' // &
                                  'number more than 0')
      end do
      checked%upper%elastic_modulus = bodies(1)%modulus(1)
      checked%lower%elastic_modulus = bodies(2)%modulus(1)
      checked%upper%poisson_ratio = bodies(1)%ratio(1)
      checked%lower%poisson_ratio = bodies(2)%ratio(1)
    end associate
  end subroutine read_bodies

  !> Refuses what is not solved with layers.
  subroutine check_layers(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(in) :: checked           !! all groups are read
    integer :: i

    if (.not. fields%has_name('material', trim(names(1))) .or. fields%lacks_file) return
    if (.not. allocated(checked%map)) then
      call refuse_layers('layers are solved on pixels: found no map, expected one')
      return
    end if
    if (.not. any(checked%bodies%thickness > 0.0_real64)) return
    if (max(checked%map%upper%strip_axis, checked%map%lower%strip_axis) > 0) &
      call refuse_layers('found beside a map that is periodic along one axis, expected both ' // &
                         'axes or none')
    if (any(checked%conductivity > 0.0_real64)) &
      call refuse_layers('found beside conductivities, which a layer changes, expected one of both')
    do i = 1, 2
      associate (name => merge('creep   ', 'friction', i == 1))
        if (checked%effects%mode(trim(name)) /= effect_off) call refuse_layers( &
          'found beside ' // trim(name) // ', which is not solved on layers, expected one of both')
      end associate
    end do

  contains

    subroutine refuse_layers(message)
      character(len=*), intent(in) :: message

      call fields%complain_of('material', trim(names(1)), message)
    end subroutine refuse_layers

  end subroutine check_layers

end module asperity_scene_layers
